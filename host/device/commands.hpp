/// Work for a device: recorded, then run to its end.
#pragma once

#include "device/kernel.hpp"

#include <type_traits>

namespace raig {

struct Groups {
    uint32_t x = 1;
    uint32_t y = 1;
    uint32_t z = 1;
};

struct RunReport {
    double seconds = 0.0;        ///< wall time from submission to the end
    double deviceSeconds = 0.0;  ///< by the device's clock, from the first command to the last; 0 if it has none
};

/// Records dispatches and runs them. Make one and keep it: its command buffer, fence and descriptors are reused.
///
///     Commands commands(device);
///     kernel.bind(0, rays);
///     commands.dispatch(kernel, {groups}, push);
///     RunReport report = commands.run();          // hits.download(...) now reads what the kernel wrote
class Commands {
public:
    explicit Commands(Device& device);
    ~Commands();
    Commands(const Commands&) = delete;
    Commands& operator=(const Commands&) = delete;

    /// Appends a dispatch with the kernel's present bindings. It sees all that earlier commands wrote.
    /// Refuses (RAIG_CHECK) an unbound binding, a buffer that is gone, push constants of another size, groups beyond the
    /// device's limits. Zero groups: nothing is recorded.
    void dispatch(const Kernel& kernel, Groups groups, std::span<const std::byte> push);
    void dispatch(const Kernel& kernel, Groups groups) { dispatch(kernel, groups, std::span<const std::byte>()); }
    template <class Push>
    requires std::is_trivially_copyable_v<Push> && std::is_class_v<Push>
    void dispatch(const Kernel& kernel, Groups groups, const Push& push) {
        dispatch(kernel, groups, std::as_bytes(std::span(&push, 1)));
    }

    /// Appends a fill of `bytes` (0: all) from `offset`, multiples of 4, with a 32-bit word; ordered as dispatches are.
    void fill(Buffer& buffer, uint32_t word, uint64_t offset = 0, uint64_t bytes = 0);

    /// Runs what was recorded and waits for it; then nothing is recorded. An empty recording costs nothing.
    /// Host reads see what the commands wrote. Throws deviceError if the device is lost. About 0.1 ms beside the work.
    RunReport run();

    /// run() in two halves: nothing may touch the buffers or be recorded in between.
    void submit();
    RunReport wait();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace raig
