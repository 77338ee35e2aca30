/// What `raig compare` found, as JSON and as JUnit's XML.
#pragma once

#include "measure/compare_bounds.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace raig {

/// Numbers that JSON has not are null: psnr of equal pictures, which is infinite, and what no pixel was compared for.
nlohmann::ordered_json toJson(const PictureDifference& difference);

/// The members `hits` to `reference_s` of the document.
nlohmann::ordered_json toJson(const SceneComparison& scene);

/// One object a bound.
nlohmann::ordered_json toJson(std::span<const CheckedBound> bounds);

/// A test for each bound, in the group `compare.SUBJECT`. `failures`: one a bound, empty if it is kept.
std::string toJUnit(const std::string& subject, std::span<const CheckedBound> bounds, std::span<const std::string> failures);

}  // namespace raig
