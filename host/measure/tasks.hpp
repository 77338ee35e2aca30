/// What is run for a point of a sweep, by the name of its task:
///
///     trace      rays through a structure, or a peer's: time, counters, memory, and hits judged
///     picture    a picture on the device against the double-precision reference
///     precision  ways to test triangles (measure/precision.hpp)
///     spawn      ways to start secondary rays (measure/spawn_policies.hpp)
#pragma once

#include "device/device.hpp"
#include "measure/chart_scene.hpp"
#include "measure/sweep.hpp"

#include <memory>

namespace raig {

/// What points are measured on and with.
struct TaskSettings {
    Device* device = nullptr;  ///< none: the CPU path
    uint32_t seed = 0;
};

class Task {
public:
    virtual ~Task() = default;
    /// True if it needs a scene.
    virtual bool needsScene() const = 0;
    /// Throws usageError if there is no such setting, or it is of the wrong kind.
    virtual void check(const Json& settings) const = 0;
    /// Measures: name -> number. `scene` is any where none is needed. Throws what building and tracing throw.
    virtual Json run(const ChartScene* scene, const Json& settings) = 0;
    /// Lets go of what is kept of the scene of the last run: it goes away.
    virtual void forgetScene() {}
    /// What each measure is, for axes: name -> "what, unit".
    virtual const Json& measures() const = 0;
};

std::unique_ptr<Task> makeTraceTask(const TaskSettings& settings);
std::unique_ptr<Task> makePictureTask(const TaskSettings& settings);

/// The task of that name. Throws usageError, which lists those there are.
std::unique_ptr<Task> makeTask(const std::string& name, const TaskSettings& settings);

/// Throws usageError if the sweep's drawings, laws or table name what is neither a setting of its points nor one of
/// `measures` (Task::measures): a law with a misspelt name would hold whatever happens.
void checkNames(const Sweep& sweep, const Json& measures);

/// The number or text of a setting, or what it is by default. Throws usageError if it is of the other kind.
double numberOf(const Json& settings, const std::string& name, double otherwise);
std::string textOf(const Json& settings, const std::string& name, const std::string& otherwise);
/// Throws usageError for a setting that is not among `known`; "label" always is.
void checkSettings(const Json& settings, const std::string& task, std::initializer_list<const char*> numbers,
                   std::initializer_list<const char*> texts);

}  // namespace raig
