// A kernel's interface, read from its SPIR-V with SPIRV-Cross.
#include "base/error.hpp"
#include "device/kernel.hpp"

#include <spirv_cross_c.h>

#include <algorithm>

namespace raig {

namespace {

/// One kernel under reflection. Kernels are compiled into the program: what SPIRV-Cross cannot read is a bug.
class Reader {
public:
    Reader(std::string_view name, std::span<const uint32_t> spirv) : name_(name) {
        require(spvc_context_create(&context_) == SPVC_SUCCESS, "memory for reflection");
        spvc_parsed_ir parsed = nullptr;
        check(spvc_context_parse_spirv(context_, spirv.data(), spirv.size(), &parsed));
        check(
            spvc_context_create_compiler(context_, SPVC_BACKEND_NONE, parsed, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler_));
        check(spvc_compiler_create_shader_resources(compiler_, &all_));
        spvc_set active = nullptr;
        check(spvc_compiler_get_active_interface_variables(compiler_, &active));
        check(spvc_compiler_create_shader_resources_for_active_variables(compiler_, &used_, active));
    }
    ~Reader() { spvc_context_destroy(context_); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    KernelInterface read(const Constants& constants) {
        KernelInterface found;
        addBindings(found, SPVC_RESOURCE_TYPE_STORAGE_BUFFER, KernelBinding::Kind::storage);
        addBindings(found, SPVC_RESOURCE_TYPE_SAMPLED_IMAGE, KernelBinding::Kind::texel);
        addBindings(found, SPVC_RESOURCE_TYPE_SEPARATE_IMAGE, KernelBinding::Kind::texel);
        for (const spvc_resource_type other :
             {SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, SPVC_RESOURCE_TYPE_STORAGE_IMAGE, SPVC_RESOURCE_TYPE_SEPARATE_SAMPLERS,
              SPVC_RESOURCE_TYPE_ATOMIC_COUNTER, SPVC_RESOURCE_TYPE_ACCELERATION_STRUCTURE})
            require(list(all_, other).empty(), "only storage buffers, texel buffers and push constants");
        found.pushBytes = pushBytes();
        found.constants = specialized(constants);
        found.workgroupSize = workgroupSize(found.constants);
        return found;
    }

private:
    void require(bool condition, const std::string& what) const {
        if (!condition) checkFailed(__FILE__, __LINE__, fmt::format("kernel {}: {}", name_, what));
    }
    void check(spvc_result result) const {
        require(result == SPVC_SUCCESS, fmt::format("readable SPIR-V ({})", spvc_context_get_last_error_string(context_)));
    }

    std::span<const spvc_reflected_resource> list(spvc_resources resources, spvc_resource_type type) const {
        const spvc_reflected_resource* first = nullptr;
        size_t count = 0;
        check(spvc_resources_get_resource_list_for_type(resources, type, &first, &count));
        return {first, count};
    }

    void addBindings(KernelInterface& found, spvc_resource_type type, KernelBinding::Kind kind) const {
        const auto active = list(used_, type);
        for (const spvc_reflected_resource& resource : list(all_, type)) {
            const uint32_t number = spvc_compiler_get_decoration(compiler_, resource.id, SpvDecorationBinding);
            require(spvc_compiler_get_decoration(compiler_, resource.id, SpvDecorationDescriptorSet) == 0,
                    fmt::format("binding {} is in descriptor set 0", number));
            const spvc_type type_handle = spvc_compiler_get_type_handle(compiler_, resource.type_id);
            KernelBinding binding;
            binding.kind = kind;
            binding.name = resource.name;
            binding.used = std::any_of(active.begin(), active.end(), [&](const auto& a) { return a.id == resource.id; });
            const unsigned dimensions = spvc_type_get_num_array_dimensions(type_handle);
            require(dimensions <= 1, fmt::format("binding {} is an array of one dimension at most", number));
            if (dimensions == 1) binding.count = spvc_type_get_array_dimension(type_handle, 0);
            require(binding.count >= 1, fmt::format("the array of binding {} has a size", number));
            if (kind == KernelBinding::Kind::texel)
                require(spvc_type_get_image_dimension(type_handle) == SpvDimBuffer,
                        fmt::format("binding {} is a texel buffer", number));
            require(found.bindings.emplace(number, binding).second, fmt::format("binding {} is declared once", number));
        }
    }

    uint32_t pushBytes() const {
        const auto blocks = list(all_, SPVC_RESOURCE_TYPE_PUSH_CONSTANT);
        if (blocks.empty()) return 0;
        size_t bytes = 0;
        check(spvc_compiler_get_declared_struct_size(
            compiler_, spvc_compiler_get_type_handle(compiler_, blocks.front().base_type_id), &bytes));
        return static_cast<uint32_t>(bytes);
    }

    /// The constants of 32 bits, as given or by default. Others, the workgroup's size itself among them, have no id.
    std::map<uint32_t, uint32_t> specialized(const Constants& given) const {
        const spvc_specialization_constant* first = nullptr;
        size_t count = 0;
        check(spvc_compiler_get_specialization_constants(compiler_, &first, &count));
        std::map<uint32_t, uint32_t> values;
        for (const auto& [id, constant_id] : std::span(first, count)) {
            const spvc_constant constant = spvc_compiler_get_constant_handle(compiler_, id);
            const spvc_type type = spvc_compiler_get_type_handle(compiler_, spvc_constant_get_type(constant));
            const bool isBool = spvc_type_get_basetype(type) == SPVC_BASETYPE_BOOLEAN;
            require(isBool || spvc_type_get_bit_width(type) == 32, fmt::format("constant {} has 32 bits", constant_id));
            const uint32_t initial = spvc_constant_get_scalar_u32(constant, 0, 0);
            values[constant_id] = isBool ? initial != 0 : initial;
        }
        for (const auto& [id, value] : given) {
            require(values.contains(id), fmt::format("specialization constant {} is declared", id));
            values[id] = value;
        }
        return values;
    }

    std::array<uint32_t, 3> workgroupSize(const std::map<uint32_t, uint32_t>& constants) const {
        std::array<spvc_specialization_constant, 3> special{};
        spvc_compiler_get_work_group_size_specialization_constants(compiler_, &special[0], &special[1], &special[2]);
        std::array<uint32_t, 3> size{};
        for (unsigned axis = 0; axis < 3; ++axis)
            size[axis] = special[axis].id != 0 ? constants.at(special[axis].constant_id)
                                               : spvc_compiler_get_execution_mode_argument_by_index(
                                                     compiler_, SpvExecutionModeLocalSize, axis);
        return size;
    }

    std::string name_;
    spvc_context context_ = nullptr;
    spvc_compiler compiler_ = nullptr;
    spvc_resources all_ = nullptr;
    spvc_resources used_ = nullptr;
};

}  // namespace

KernelInterface reflect(std::string_view name, std::span<const uint32_t> spirv, const Constants& constants) {
    return Reader(name, spirv).read(constants);
}

}  // namespace raig
