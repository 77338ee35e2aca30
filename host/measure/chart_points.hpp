/// The points of a chart on disk, as they are measured: so that a sweep which is interrupted goes on where it was.
#pragma once

#include "measure/chart_document.hpp"

#include <filesystem>
#include <fstream>
#include <map>

namespace raig {

/// One line a point, points.jsonl: what was measured, on what, and what came out. Lines that are cut short or damaged, and
/// those of another identity, are passed over.
class PointStore {
public:
    /// `identity` names all that a point depends on beside its task, scene and settings: the program, the device, the seed.
    /// Throws inputError if the file cannot be written.
    PointStore(const std::filesystem::path& file, std::string identity);

    /// The point with its measures, if it was measured before. `sceneHash` tells scenes of one name apart.
    std::optional<ChartPoint> find(const std::string& task, const std::string& sceneHash, const Json& settings) const;
    /// Appends one, at once. Throws inputError if that fails.
    void add(const std::string& task, const std::string& sceneHash, const ChartPoint& point);

private:
    std::filesystem::path file_;
    std::string identity_;
    std::map<std::string, ChartPoint> points_;  ///< by task, hash and settings, as JSON
    std::ofstream out_;
};

/// What of a figure's points lies outside what theory says (Sweep::laws), a line each, in order; and laws that no point,
/// though some were measured, is about.
std::vector<Breach> findBreaches(const Sweep& sweep, const std::vector<ChartPoint>& points);

/// "levels 2, grid-density 4": settings in words, without those named.
std::string describeSettings(const Json& settings, const std::vector<std::string>& without = {});

/// A setting or measure of a point as a number; "scene" has none. Nothing where it is missing, null or a text.
std::optional<double> valueOf(const ChartPoint& point, const std::string& name);

/// The value of a setting, or of "scene", as text: numbers with up to nine digits. Empty where there is none.
std::string nameOf(const ChartPoint& point, const std::string& name);

}  // namespace raig
