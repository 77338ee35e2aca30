#include "measure/stress.hpp"

#include "base/error.hpp"
#include "measure/oracle.hpp"
#include "measure/stress_answers.hpp"
#include "rays/placed_scene.hpp"
#include "rays/tracer.hpp"

#include <algorithm>

namespace raig {

namespace {

constexpr size_t mostExamples = 3;

StressExample exampleOf(const hard::Scene& scene, const hard::Oracle& oracle, const StressAnswers& answers,
                        const StressAnswers* yardstick, size_t i, StressFault fault) {
    const std::string found = fault == StressFault::hung || fault == StressFault::error
                                  ? answers.thrown
                                  : fmt::format("finds {}", hard::describe(answers.closest[i]));
    const std::string beside = fault == StressFault::any ? fmt::format(", and {} for any", hard::describe(answers.any[i]))
                               : fault == StressFault::differs
                                   ? fmt::format(", brute {}", hard::describe(yardstick->closest[i]))
                                   : "";
    return {0, scene.name, fault,
            fmt::format("{}: {}{}; exactly: {}{}", hard::describe(scene.rays[i]), found, beside,
                        hard::describe(oracle.closest(scene.rays[i])),
                        scene.meets.empty() ? "" : fmt::format("; must be: primitive {}", scene.meets[i]))};
}

/// Adds the answers to a scene, whose first ray is ray `first` of the case.
void add(StressResult& result, const hard::Scene& scene, const hard::Oracle& oracle, const StressAnswers& answers,
         const StressAnswers* yardstick, uint64_t first) {
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

StressReplay::Answer answerOf(const StressSubject& subject, const std::string& device, const StressAnswers& answers) {
    StressReplay::Answer answer{subject.structure, subject.options, device, answers.closest[0], answers.any[0], {},
                                answers.thrown};
    for (const StressFault fault : {answers.closestFaults[0], answers.anyFaults[0]})
        if (fault != StressFault::none) answer.faults.push_back(fault);
    return answer;
}

Structure buildOver(const hard::Scene& scene, const Variant& variant) {
    if (!scene.placed || variant.structure == "brute") return variant.build(scene.triangles);
    const Geometry geometry = gatherInstances(*scene.placed);
    return buildTwoLevels(placedScene(geometry, {}), structureType(variant.structure), variant.params);
}

/// Of the scene, only the rays of these numbers.
void keepRays(hard::Scene& scene, const std::vector<size_t>& kept) {
    std::vector<Ray> rays;
    std::vector<uint32_t> meets;
    for (const size_t i : kept) {
        rays.push_back(scene.rays[i]);
        if (!scene.meets.empty()) meets.push_back(scene.meets[i]);
    }
    scene.rays = std::move(rays);
    scene.meets = std::move(meets);
}

/// Leaves of the scenes only the ray of that number. Throws usageError if there is none.
void keepOnly(std::vector<hard::Scene>& scenes, uint64_t number) {
    uint64_t at = number, all = 0;
    for (const hard::Scene& scene : scenes) all += scene.rays.size();
    if (number >= all) throw usageError("--ray {}: the case has {} rays, from 0 on", number, all);
    for (hard::Scene& scene : scenes) {
        const uint64_t here = scene.rays.size();
        keepRays(scene, at < here ? std::vector<size_t>{at} : std::vector<size_t>{});
        at = at < here ? ~uint64_t{0} : at == ~uint64_t{0} ? at : at - here;
    }
}

/// What ended the run, and where. Nothing if nothing did.
std::optional<Error> stopOf(const StressAnswers& answers, uint32_t number, const StressSubject& subject,
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
    StressAnswers onCpu, brute;
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
        const StressAnswers* const yardstick = i > 0 ? &brute : settings.bruteOnCpu ? &onCpu : nullptr;
        StressAnswers answers = askAll(subjects[i], scene);
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
    const auto prepare = [variant, device](const hard::Scene& scene) -> AnswerRays {
        const auto structure = std::make_shared<Structure>(buildOver(scene, variant));
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
        std::vector<size_t> kept;
        for (; picked < rays && picked * all / rays < end; ++picked) kept.push_back(picked * all / rays - first);
        keepRays(scene, kept);
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
