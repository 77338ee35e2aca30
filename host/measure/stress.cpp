#include "measure/stress.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "measure/oracle.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <new>

namespace raig {

namespace {

constexpr size_t mostExamples = 3;

/// What a subject answers to the rays of a scene.
struct Answers {
    std::vector<Hit> closest, any;
    std::vector<StressFault> closestFaults, anyFaults;
    std::vector<uint8_t> open;
    std::string thrown;
    std::optional<Error> stopped;  ///< what leaves no use in asking on
    double seconds = 0.0;
};

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
           std::vector<StressFault>& faults, Answers& answers)
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
    Answers& answers_;
    size_t hangs_ = 0;
};

Answers askAll(const StressSubject& subject, const hard::Scene& scene) {
    const size_t count = scene.rays.size();
    const Hit none{0.0f, 0.0f, 0.0f, NO_HIT};
    Answers answers{.closest = std::vector<Hit>(count, none),
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
        answer = subject.prepare(scene.triangles);
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

/// Fills in what is wrong with answers that are there. Those with the bits of `yardstick` have its faults, and cost nothing.
void judge(Answers& answers, const hard::Scene& scene, const hard::Oracle& oracle, const Answers* yardstick) {
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
            if (fault == StressFault::none && answered) fault = StressFault::differs;
        }
    });
}

StressExample exampleOf(const hard::Scene& scene, const hard::Oracle& oracle, const Answers& answers,
                        const Answers* yardstick, size_t i, StressFault fault) {
    const std::string found = fault == StressFault::hung || fault == StressFault::error
                                  ? answers.thrown
                                  : fmt::format("finds {}", hard::describe(answers.closest[i]));
    const std::string beside = fault == StressFault::any ? fmt::format(", and {} for any", hard::describe(answers.any[i]))
                               : fault == StressFault::differs
                                   ? fmt::format(", brute {}", hard::describe(yardstick->closest[i]))
                                   : "";
    return {0, scene.name, fault,
            fmt::format("{}: {}{}; exactly: {}", hard::describe(scene.rays[i]), found, beside,
                        hard::describe(oracle.closest(scene.rays[i])))};
}

/// Adds the answers to a scene, whose first ray is ray `first` of the case.
void add(StressResult& result, const hard::Scene& scene, const hard::Oracle& oracle, const Answers& answers,
         const Answers* yardstick, uint64_t first) {
    result.rays += scene.rays.size();
    result.seconds += answers.seconds;
    for (size_t i = 0; i < scene.rays.size(); ++i) {
        result.hits += answers.closest[i].primitive != NO_HIT;
        result.open += answers.open[i];
        const StressFault closest = answers.closestFaults[i], any = answers.anyFaults[i];
        result.faulty += closest != StressFault::none || any != StressFault::none;
        for (const StressFault fault : {closest, any == closest ? StressFault::none : any}) {
            if (fault == StressFault::none) continue;
            ++result.counts[static_cast<size_t>(fault)];
            if (result.examples.size() == mostExamples) continue;
            result.examples.push_back(exampleOf(scene, oracle, answers, yardstick, i, fault));
            result.examples.back().ray = first + i;
        }
    }
}

StressReplay::Answer answerOf(const StressSubject& subject, const std::string& device, const Answers& answers) {
    StressReplay::Answer answer{subject.structure, subject.options, device, answers.closest[0], answers.any[0], {},
                                answers.thrown};
    for (const StressFault fault : {answers.closestFaults[0], answers.anyFaults[0]})
        if (fault != StressFault::none) answer.faults.push_back(fault);
    return answer;
}

/// Leaves of the scenes only the ray of that number. Throws usageError if there is none.
void keepOnly(std::vector<hard::Scene>& scenes, uint64_t number) {
    uint64_t at = number, all = 0;
    for (const hard::Scene& scene : scenes) all += scene.rays.size();
    if (number >= all) throw usageError("--ray {}: the case has {} rays, from 0 on", number, all);
    for (hard::Scene& scene : scenes) {
        const uint64_t here = scene.rays.size();
        scene.rays = at < here ? std::vector{scene.rays[at]} : std::vector<Ray>{};
        at = at < here ? ~uint64_t{0} : at == ~uint64_t{0} ? at : at - here;
    }
}

/// What ended the run, and where. Nothing if nothing did.
std::optional<Error> stopOf(const Answers& answers, uint32_t number, const StressSubject& subject,
                            const std::string& device) {
    if (!answers.stopped) return std::nullopt;
    return Error(answers.stopped->exitCode,
                 fmt::format("case {}, {}{}{} on {}: {}", number, subject.structure, subject.options.empty() ? "" : " ",
                             subject.options, device, answers.stopped->what()));
}

/// All subjects, brute first, with the rays of a scene, whose first is ray `first` of the case. Returns what ended that
/// early.
std::optional<Error> runScene(const StressSettings& settings, const std::vector<StressSubject>& subjects,
                              const hard::Scene& scene, uint64_t first, std::vector<StressResult>& results,
                              std::optional<StressReplay>& replay, const std::function<void(double)>& tell) {
    const hard::Oracle oracle(scene.triangles);
    Answers onCpu, brute;
    if (settings.bruteOnCpu) {
        onCpu = askAll(*settings.bruteOnCpu, scene);
        if (onCpu.stopped) return stopOf(onCpu, results[0].number, *settings.bruteOnCpu, "cpu");
        judge(onCpu, scene, oracle, nullptr);
    }
    if (settings.ray)
        replay = StressReplay{scene.name,
                              scene.triangles.size(),
                              scene.rays[0],
                              oracle.closest(scene.rays[0]),
                              !scene.exact && oracle.isOpen(scene.rays[0]),
                              {}};
    for (size_t i = 0; i < subjects.size(); ++i) {
        tell(double(i) / double(subjects.size()));
        const Answers* const yardstick = i > 0 ? &brute : settings.bruteOnCpu ? &onCpu : nullptr;
        Answers answers = askAll(subjects[i], scene);
        const std::optional<Error> stop = stopOf(answers, results[i].number, subjects[i], settings.device);
        if (stop && stop->exitCode == ExitCode::limit) return stop;
        judge(answers, scene, oracle, yardstick);
        add(results[i], scene, oracle, answers, yardstick, first);
        if (replay) replay->answers.push_back(answerOf(subjects[i], settings.device, answers));
        if (stop) return stop;
        if (i == 0) brute = std::move(answers);
    }
    return std::nullopt;
}

}  // namespace

uint64_t StressReport::forbidden() const {
    uint64_t sum = 0;
    for (const StressResult& result : results) sum += result.forbidden();
    return sum;
}

StressSubject subjectOf(const Variant& variant, Device* device) {
    const auto prepare = [variant, device](std::span<const Triangle> triangles) -> AnswerRays {
        const auto structure = std::make_shared<Structure>(variant.build(triangles));
        const std::shared_ptr<Tracer> tracer =
            device != nullptr ? std::shared_ptr<Tracer>(makeDeviceTracer(*device, *structure)) : makeCpuTracer(*structure);
        return [structure, tracer](std::span<const Ray> rays, std::span<Hit> hits, Query query) {
            tracer->trace(rays, hits, query);
        };
    };
    return {variant.structure, describeOptions(variant.params) + (variant.params.nestsGrids ? " (nested)" : ""), prepare};
}

std::vector<hard::Scene> drawScenes(const hard::Case& hardCase, hard::Draw draw, uint64_t rays) {
    const auto countOf = [](const std::vector<hard::Scene>& scenes) {
        uint64_t count = 0;
        for (const hard::Scene& scene : scenes) count += scene.rays.size();
        return count;
    };
    std::vector<hard::Scene> scenes = hardCase.make(draw);
    uint64_t all = countOf(scenes);
    if (rays == 0 || rays == all) return scenes;
    if (rays > all) {
        draw.times *= static_cast<uint32_t>((rays + all - 1) / all);
        scenes = hardCase.make(draw);
        all = countOf(scenes);
        RAIG_CHECK_OP(all, >=, rays);
    }
    uint64_t picked = 0, first = 0;
    for (hard::Scene& scene : scenes) {
        const uint64_t end = first + scene.rays.size();
        std::vector<Ray> some;
        for (; picked < rays && picked * all / rays < end; ++picked) some.push_back(scene.rays[picked * all / rays - first]);
        scene.rays = std::move(some);
        first = end;
    }
    return scenes;
}

StressReport stress(const StressSettings& settings, const std::function<void(const std::string&, double)>& progress) {
    StressReport report;
    std::vector<StressSubject> subjects = {settings.brute};
    subjects.insert(subjects.end(), settings.subjects.begin(), settings.subjects.end());
    for (size_t index = 0; index < settings.cases.size(); ++index) {
        const hard::Case& hardCase = settings.cases[index];
        std::vector<hard::Scene> scenes = drawScenes(hardCase, settings.draw, settings.rays);
        if (settings.ray) keepOnly(scenes, *settings.ray);
        std::vector<StressResult> results;
        for (const StressSubject& subject : subjects)
            results.push_back({.number = hardCase.number,
                               .structure = subject.structure,
                               .options = subject.options,
                               .device = settings.device,
                               .deviceNumber = settings.deviceNumber,
                               .examples = {}});
        uint64_t first = settings.ray.value_or(0);
        for (size_t i = 0; i < scenes.size() && !report.stopped; ++i) {
            if (scenes[i].rays.empty()) continue;
            const auto tell = [&](double done) {
                progress(fmt::format("case {}", hardCase.number),
                         (double(index) + (double(i) + done) / double(scenes.size())) / double(settings.cases.size()));
            };
            report.stopped = runScene(settings, subjects, scenes[i], first, results, report.replay, tell);
            first += scenes[i].rays.size();
        }
        std::erase_if(results, [](const StressResult& result) { return result.rays == 0; });  // not reached
        report.results.insert(report.results.end(), results.begin(), results.end());
        if (report.stopped) break;
    }
    return report;
}

}  // namespace raig
