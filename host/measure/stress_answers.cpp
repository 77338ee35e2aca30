#include "measure/stress_answers.hpp"

#include "base/parallel.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <new>

namespace raig {

namespace {

/// True for a lost device and for a limit: neither is an answer of the structure's.
bool endsRun(const Error& error) {
    return error.exitCode == ExitCode::noDevice || error.exitCode == ExitCode::limit;
}

bool sameBits(const Hit& a, const Hit& b) {
    return std::memcmp(&a, &b, sizeof(Hit)) == 0;
}

/// Asks for all rays at once; where a walk does not end, in halves, so that rays which lead it astray are told from the
/// others. After many, a part is given up as a whole.
class Asking {
public:
    Asking(const AnswerRays& answer, const std::vector<Ray>& rays, Query query, std::vector<Hit>& hits,
           std::vector<StressFault>& faults, StressAnswers& answers)
        : answer_(answer), rays_(rays), query_(query), hits_(hits), faults_(faults), answers_(answers) {}

    void ask(size_t begin, size_t end) {
        if (begin == end) return;
        if (answers_.stopped) return giveUp(begin, end, StressFault::error);
        try {
            answer_(std::span(rays_).subspan(begin, end - begin), std::span(hits_).subspan(begin, end - begin), query_);
        } catch (const CorruptStructure& corrupt) {
            answers_.thrown = corrupt.what();
            if (end - begin == 1 || ++hangs_ > mostHangs) return giveUp(begin, end, StressFault::hung);
            const size_t middle = begin + (end - begin) / 2;
            ask(begin, middle);
            ask(middle, end);
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const Error& error) {
            answers_.thrown = error.what();
            if (endsRun(error)) answers_.stopped = error;
            giveUp(begin, end, StressFault::error);
        } catch (const std::exception& other) {
            answers_.thrown = other.what();
            giveUp(begin, end, StressFault::error);
        }
    }

private:
    static constexpr size_t mostHangs = 200;

    void giveUp(size_t begin, size_t end, StressFault fault) {
        std::fill(faults_.begin() + static_cast<std::ptrdiff_t>(begin), faults_.begin() + static_cast<std::ptrdiff_t>(end),
                  fault);
        std::fill(hits_.begin() + static_cast<std::ptrdiff_t>(begin), hits_.begin() + static_cast<std::ptrdiff_t>(end),
                  Hit{0.0f, 0.0f, 0.0f, NO_HIT});
    }

    const AnswerRays& answer_;
    const std::vector<Ray>& rays_;
    Query query_;
    std::vector<Hit>& hits_;
    std::vector<StressFault>& faults_;
    StressAnswers& answers_;
    size_t hangs_ = 0;
};

StressFault faultOf(const hard::Judgement& judgement) {
    if (!judgement.isFault()) return StressFault::none;
    if (judgement.open) return StressFault::wrong;  // a hit that is nowhere near its triangle
    switch (judgement.verdict) {
        case hard::Verdict::missed:
            return StressFault::missed;
        case hard::Verdict::phantom:
            return StressFault::phantom;
        default:
            return StressFault::wrong;
    }
}

}  // namespace

StressAnswers askAll(const StressSubject& subject, const hard::Scene& scene) {
    const size_t count = scene.rays.size();
    const Hit none{0.0f, 0.0f, 0.0f, NO_HIT};
    StressAnswers answers{.closest = std::vector<Hit>(count, none),
                          .any = std::vector<Hit>(count, none),
                          .closestFaults = std::vector<StressFault>(count, StressFault::none),
                          .anyFaults = std::vector<StressFault>(count, StressFault::none),
                          .open = std::vector<uint8_t>(count, 0),
                          .thrown = "",
                          .stopped = {},
                          .seconds = 0.0};
    const auto start = std::chrono::steady_clock::now();
    AnswerRays answer;
    try {
        answer = subject.prepare(scene);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const Error& error) {
        answers.thrown = error.what();
        if (endsRun(error)) answers.stopped = error;
    } catch (const std::exception& other) {
        answers.thrown = other.what();
    }
    if (answer) {
        Asking(answer, scene.rays, Query::closest, answers.closest, answers.closestFaults, answers).ask(0, count);
        Asking(answer, scene.rays, Query::any, answers.any, answers.anyFaults, answers).ask(0, count);
    } else {
        answers.closestFaults.assign(count, StressFault::error);
    }
    answers.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return answers;
}

void judge(StressAnswers& answers, const hard::Scene& scene, const hard::Oracle& oracle, const StressAnswers* yardstick) {
    parallelFor(scene.rays.size(), 32, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            StressFault& fault = answers.closestFaults[i];
            if (fault != StressFault::none) continue;
            if (answers.anyFaults[i] == StressFault::none &&
                (answers.any[i].primitive == NO_HIT) != (answers.closest[i].primitive == NO_HIT))
                answers.anyFaults[i] = StressFault::any;
            const StressFault wanted = yardstick != nullptr ? yardstick->closestFaults[i] : StressFault::error;
            const bool answered = wanted != StressFault::hung && wanted != StressFault::error;
            if (answered && sameBits(answers.closest[i], yardstick->closest[i])) {
                fault = wanted == StressFault::differs ? StressFault::none : wanted;
                answers.open[i] = yardstick->open[i];
                continue;
            }
            const hard::Judgement judgement = oracle.judge(scene.rays[i], answers.closest[i], scene.exact);
            fault = faultOf(judgement);
            answers.open[i] = judgement.open;
            if (!scene.meets.empty() && answers.closest[i].primitive != scene.meets[i])
                fault = answers.closest[i].primitive == NO_HIT ? StressFault::missed : StressFault::phantom;
            if (fault == StressFault::none && answered) fault = StressFault::differs;
        }
    });
}

}  // namespace raig
