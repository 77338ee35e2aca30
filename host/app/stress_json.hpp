/// What `raig stress` found, as JSON and as JUnit's XML.
#pragma once

#include "measure/stress_page.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace raig {

/// `arithmetic`: of the devices, as JSON, in their order.
nlohmann::ordered_json toJson(const StressDocument& document, const std::vector<nlohmann::ordered_json>& arithmetic,
                              const std::optional<StressReplay>& replay);

/// A test for each case and structure, and one for each control.
std::string toJUnit(const StressDocument& document);

}  // namespace raig
