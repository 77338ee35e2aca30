#include "app/bench_baseline.hpp"

#include "app/machine.hpp"
#include "base/error.hpp"
#include "base/files.hpp"
#include "measure/bench.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t largestFile = size_t{256} << 20;

/// A median that can be compared; nothing where it was not measured.
std::optional<double> medianOf(const Json& row, const char* key) {
    const auto found = row.find(key);
    if (found == row.end() || found->is_null()) return std::nullopt;
    const double value = found->at("median").get<double>();
    return std::isfinite(value) && value > 0.0 ? std::optional(value) : std::nullopt;
}

/// What a row is of: rows of two runs are comparable where this is the same.
std::string subjectOf(const Json& row) {
    Json subject = Json::array();
    for (const char* const key :
         {"scene", "triangles", "structure", "options", "device", "threads", "rays", "query", "count"})
        subject.push_back(row.at(key));
    return subject.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Calls `visit(subject, row)` for the rows that are no peer's. Where two are of the same, as of files of one name in two
/// folders, they are told apart by their order.
template <class Visit>
void forEachOwnRow(const Json& document, const Visit& visit) {
    std::map<std::string, int> seen;
    for (const Json& row : document.at("results")) {
        if (isPeer(row.at("structure").get<std::string>())) continue;
        const std::string subject = subjectOf(row);
        visit(subject + "#" + std::to_string(seen[subject]++), row);
    }
}

}  // namespace

BenchBaseline::BenchBaseline(const std::filesystem::path& file) : file_(file) {
    const std::vector<std::byte> bytes = readFile(file, largestFile);
    try {
        const auto* const text = reinterpret_cast<const char*>(bytes.data());
        const Json document = Json::parse(text, text + bytes.size());
        commit_ = document.value("commit", commit_);
        forEachOwnRow(document, [&](const std::string& subject, const Json& row) {
            rows_[subject] = {row.at("scene"), row.at("threads"), medianOf(row, "ratio_to_embree"),
                              medianOf(row, "mrays_per_s")};
        });
    } catch (const Json::exception&) {
        throw inputError(file.string(), "this is no document of raig bench --json");
    }
}

void BenchBaseline::requireSome(const std::vector<std::string>& scenes) const {
    const auto isComparable = [&](const auto& row) {
        return row.second.threads == threadCount() && std::ranges::find(scenes, row.second.scene) != scenes.end();
    };
    if (std::ranges::none_of(rows_, isComparable))
        throw inputError(file_.string(), "it has nothing to compare with: no such scene was measured with {} threads",
                         threadCount());
}

Error BenchBaseline::nothingInCommon() const {
    return inputError(
        file_.string(),
        "it has nothing in common with this run: of a row, scene, structure, options, device, threads, rays and "
        "their number must be the same");
}

std::vector<BenchChange> BenchBaseline::changes(const Json& document, size_t& alone) const {
    std::vector<BenchChange> changes;
    alone = 0;
    forEachOwnRow(document, [&](const std::string& subject, const Json& row) {
        const auto found = rows_.find(subject);
        ++alone;  // until it is compared
        if (found == rows_.end()) return;
        const Row& before = found->second;
        const std::optional<double> ratio = medianOf(row, "ratio_to_embree"), megaRays = medianOf(row, "mrays_per_s");
        BenchChange change{row.at("scene"),  row.at("structure"), row.at("options"),
                           row.at("device"), row.at("rays"),      row.at("query")};
        if (before.ratio && ratio) {
            change.isRatio = true;
            change.before = *before.ratio;
            change.now = *ratio;
        } else if (before.megaRays && megaRays) {
            change.before = *before.megaRays;
            change.now = *megaRays;
        } else {
            return;
        }
        changes.push_back(change);
        --alone;
    });
    return changes;
}

Json toJson(const std::vector<BenchChange>& changes) {
    Json list = Json::array();
    for (const BenchChange& c : changes)
        list.push_back({{"scene", c.scene},
                        {"structure", c.structure},
                        {"options", c.options},
                        {"device", c.device},
                        {"rays", c.rays},
                        {"query", c.query},
                        {"metric", c.isRatio ? "ratio_to_embree" : "mrays_per_s"},
                        {"before", c.before},
                        {"now", c.now},
                        {"factor", c.factor()}});
    return list;
}

void printChanges(const std::vector<BenchChange>& changes, double slower) {
    fmt::print("{:28} {:10} {:11} {:9} {:8} {:15} {:>9} {:>9} {:>9}\n", "scene", "structure", "device", "rays", "query", "",
               "before", "now", "factor");
    for (const BenchChange& c : changes)
        fmt::print("{:28.28} {:10} {:11.11} {:9} {:8} {:15} {:>9.3f} {:>9.3f} {:>9.3f}{}\n", c.scene, c.structure,
                   c.device.substr(0, c.device.find(' ')), c.rays, c.query, c.isRatio ? "of Embree's" : "Mrays/s", c.before,
                   c.now, c.factor(), c.factor() * slower < 1.0 ? "  slower" : "");
    fmt::print("\n");
}

}  // namespace raig
