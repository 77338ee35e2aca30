/// An earlier run of `raig bench`, and what has changed since.
#pragma once

#include "base/error.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace raig {

/// What was measured of one structure with one set of rays, in two runs.
struct BenchChange {
    std::string scene, structure, options, device, rays, query;
    bool isRatio = false;  ///< to Embree, which says the same on other machines; else Mrays/s
    double before = 0.0, now = 0.0;

    /// Above 1: faster than before.
    double factor() const { return now / before; }
};

class BenchBaseline {
public:
    /// Of a file with the document that `raig bench --json` prints. Throws inputError.
    explicit BenchBaseline(const std::filesystem::path& file);

    /// Throws inputError where nothing of the scenes (names of files) was measured with as many threads: no run of these can
    /// have anything in common with the baseline.
    void requireSome(const std::vector<std::string>& scenes) const;

    /// Of the rows of `document` that the baseline has, too: same scene, triangles, structure, options, device, threads and
    /// rays. Peers are not looked at. Medians are compared. `alone`: how many rows of the document have none to compare
    /// with.
    std::vector<BenchChange> changes(const nlohmann::ordered_json& document, size_t& alone) const;
    /// Where all rows are alone.
    Error nothingInCommon() const;

    /// The commit it was measured at; "unknown" where it does not say.
    const std::string& commit() const { return commit_; }

private:
    struct Row {
        std::string scene;
        uint64_t threads;
        std::optional<double> ratio, megaRays;
    };
    std::filesystem::path file_;
    std::string commit_ = "unknown";
    std::map<std::string, Row> rows_;  ///< by what they are of
};

nlohmann::ordered_json toJson(const std::vector<BenchChange>& changes);

/// On standard output; those by which speed fell below 1 / `slower` of what it was are marked.
void printChanges(const std::vector<BenchChange>& changes, double slower);

}  // namespace raig
