/// What a subject of the hard cases answers, and what is wrong with it.
#pragma once

#include "measure/oracle.hpp"
#include "measure/stress.hpp"

namespace raig {

/// What a subject answers to the rays of a scene.
struct StressAnswers {
    std::vector<Hit> closest, any;
    std::vector<StressFault> closestFaults, anyFaults;
    std::vector<uint8_t> open;
    std::string thrown;
    std::optional<Error> stopped;  ///< what leaves no use in asking on
    double seconds = 0.0;
};

/// Asks the subject for the closest hit of each ray, and for any. Where a walk does not end, the rays that lead it astray
/// are told from the others. Throws std::bad_alloc; all else that is thrown is in the answers.
StressAnswers askAll(const StressSubject& subject, const hard::Scene& scene);

/// Fills in what is wrong with answers that are there. Those with the bits of `yardstick` have its faults, and cost nothing.
void judge(StressAnswers& answers, const hard::Scene& scene, const hard::Oracle& oracle, const StressAnswers* yardstick);

}  // namespace raig
