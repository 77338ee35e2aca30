/// A compute kernel: SPIR-V made into a pipeline, its bindings checked against what the SPIR-V itself declares.
#pragma once

#include "device/buffer.hpp"

#include <map>

namespace raig {

/// A resource of descriptor set 0.
struct KernelBinding {
    enum class Kind { storage, texel };
    Kind kind = Kind::storage;
    uint32_t count = 1;  ///< of the array of descriptors
    bool used = false;   ///< by the code: only these must be bound
    std::string name;
};

/// What a kernel asks of its caller, read from its SPIR-V.
struct KernelInterface {
    std::map<uint32_t, KernelBinding> bindings;
    uint32_t pushBytes = 0;
    std::array<uint32_t, 3> workgroupSize{1, 1, 1};  ///< specialized
    std::map<uint32_t, uint32_t> constants;          ///< specialization constants: id and value, defaults included
};

/// Specialization constants by id: bools are 0 or 1, floats are their bits.
using Constants = std::map<uint32_t, uint32_t>;

/// Reads the interface of the compute entry point "main", specialized. Refuses (RAIG_CHECK) what raig's kernels do not
/// have: other descriptor sets, images, uniform blocks, specialization constants of other than 32 bits, unknown ids.
KernelInterface reflect(std::string_view name, std::span<const uint32_t> spirv, const Constants& constants);

class Kernel {
public:
    /// `name` is for messages. `spirv` is needed during the call only. Cost: up to 0.2 s on lavapipe when first seen, up to
    /// 0.08 s from the cache, and next to nothing where the device has made the same before. Refuses (RAIG_CHECK) a
    /// workgroup or push constants beyond the device's limits. Throws deviceError if the driver cannot compile it.
    Kernel(Device& device, std::string_view name, std::span<const uint32_t> spirv, const Constants& constants = {});
    ~Kernel();
    Kernel(Kernel&&) noexcept;
    Kernel& operator=(Kernel&&) noexcept;

    const KernelInterface& interface() const;

    /// Binds for the dispatches recorded from now on; may be called again. The buffer must live until those have run.
    /// Refuses (RAIG_CHECK) a binding that the kernel does not declare, an array of descriptors, or texels of a buffer
    /// without.
    void bind(uint32_t binding, const Buffer& buffer);
    /// A BigArray binds to storage or texel descriptors, as declared; refused if it has more chunks than those.
    void bind(uint32_t binding, const BigArray& array);

    struct State;  ///< device/vulkan.hpp
    State& state() const { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace raig
