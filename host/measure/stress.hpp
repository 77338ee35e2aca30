/// The hard cases, run: how often which structure misses, invents or misplaces a hit, by exact arithmetic.
#pragma once

#include "base/error.hpp"
#include "device/device.hpp"
#include "measure/hard_cases.hpp"
#include "measure/variants.hpp"
#include "rays/types.hpp"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raig {

/// What can be wrong with the answer to a ray. The first three as the oracle (measure/oracle.hpp) says, where a hit that is
/// farther from its triangle than rounding explains is wrong, too.
enum class StressFault : uint8_t {
    none,
    missed,
    phantom,
    wrong,
    differs,  ///< other bits than brute force's on the same device, though the oracle finds no fault with them; of brute
              ///< force: than the CPU's, where the device computes alike
    any,      ///< an any-hit query has a hit where the closest-hit query has none, or the other way round
    hung,     ///< the walk does not end
    error,    ///< there is no answer, as something was thrown, or the device was lost
};
inline constexpr size_t stressFaults = 8;
inline constexpr const char* stressFaultNames[stressFaults] = {"none",    "missed", "phantom", "wrong",
                                                               "differs", "any",    "hung",    "error"};

/// hits[i] = the answer to rays[i]. May throw what a Tracer does.
using AnswerRays = std::function<void(std::span<const Ray> rays, std::span<Hit> hits, Query query)>;

/// What is put to the test.
struct StressSubject {
    std::string structure;
    std::string options;  ///< as on the command line; empty: none
    std::function<AnswerRays(const hard::Scene&)> prepare;
};

/// A structure on a device, or on the CPU where there is none; in two levels where the scene has meshes in several places,
/// but for brute, which tries what is written out. The device must outlive the subject.
StressSubject subjectOf(const Variant& variant, Device* device);

struct StressSettings {
    std::vector<hard::Case> cases;
    hard::Draw draw;
    uint64_t rays = 0;                        ///< a case; 0: as many as the draw gives
    std::optional<uint64_t> ray;              ///< only this one, by its number among all rays of the one case
    std::string device;                       ///< its name, for the results
    size_t deviceNumber = 0;                  ///< among all devices of the run, for the results
    StressSubject brute;                      ///< what the others' bits are compared with; judged first, as they are
    std::optional<StressSubject> bruteOnCpu;  ///< what brute's bits are compared with
    std::vector<StressSubject> subjects;
};

/// A ray that was not answered right.
struct StressExample {
    uint64_t ray = 0;  ///< as StressSettings::ray
    std::string scene;
    StressFault fault = StressFault::none;
    std::string what;  ///< the ray, what was found, and what should have been
};

/// What became of the rays of one case with one subject.
struct StressResult {
    uint32_t number = 0;  ///< of the case
    std::string structure, options, device;
    size_t deviceNumber = 0;  ///< devices may share a name
    bool isOfPixels = false;  ///< what is said of rays is of pixels
    uint64_t rays = 0;
    uint64_t hits = 0;                    ///< rays that hit something, by the subject
    uint64_t open = 0;                    ///< rays that the oracle would fault, did rounding not decide there
    uint64_t faulty = 0;                  ///< rays with a fault, of one kind or more
    uint64_t counts[stressFaults] = {};   ///< rays by their faults: closest-hit and any-hit query may each have one
    std::vector<StressExample> examples;  ///< the first few
    double seconds = 0.0;                 ///< to build and to trace

    std::string name() const { return options.empty() ? structure : structure + " " + options; }
    uint64_t count(StressFault fault) const { return counts[static_cast<size_t>(fault)]; }
    /// Rays with an answer that must not be. No more than there are rays.
    uint64_t forbidden() const { return faulty; }
};

/// One ray, and what each says of it.
struct StressReplay {
    struct Answer {
        std::string structure, options, device;
        Hit closest{}, any{};
        std::vector<StressFault> faults;  ///< none if empty
        std::string thrown;
    };
    std::string scene;
    size_t triangles = 0;
    Ray ray{};
    Hit exact{};
    bool open = false;
    std::vector<Answer> answers;
};

struct StressReport {
    std::vector<StressResult> results;
    std::optional<StressReplay> replay;  ///< where one ray was asked for
    /// Why the run ended before all was done, with the case, the subject and the device: that was lost, or a limit was
    /// reached. The results are those of what was done by then; rays that a lost device did not answer are errors.
    std::optional<Error> stopped;

    uint64_t forbidden() const;
};

/// The scenes of the case with `rays` rays in all, spread evenly over those drawn; all that are drawn where it is 0.
/// Ensures that the same arguments give the same rays.
std::vector<hard::Scene> drawScenes(const hard::Case& hardCase, hard::Draw draw, uint64_t rays);

/// Runs all cases with all subjects. `progress` is told what is at hand and the share done. Throws usageError if there is
/// no ray of the number asked for, and std::bad_alloc. A lost device and a limit end the run, see StressReport::stopped; all
/// else that is thrown counts as an error, and the run goes on.
StressReport stress(const StressSettings& settings, const std::function<void(const std::string&, double)>& progress);

}  // namespace raig
