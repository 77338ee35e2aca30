// The Vulkan instance: which drivers are loaded, and what validation says.
#include "base/log.hpp"
#include "device/vulkan.hpp"

#include <cstdlib>
#include <cstring>
#include <mutex>

namespace raig {

namespace {

std::mutex messageLock;
std::vector<std::string> messages;
bool validating = false;

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
    const std::lock_guard guard(messageLock);
    messages.emplace_back(data->pMessage);
    log::warnText(messages.back());
    return VK_FALSE;
}

/// Sets an environment variable until the end of the scope, unless it is set: loader and layers read their settings there
/// alone, and what raig starts later should not inherit ours.
class ScopedVariable {
public:
    ScopedVariable(const char* name, const std::string& value) : name_(name) {
        set_ = std::getenv(name) == nullptr && ::setenv(name, value.c_str(), 0) == 0;
    }
    ScopedVariable(const ScopedVariable&) = delete;
    ScopedVariable& operator=(const ScopedVariable&) = delete;
    ~ScopedVariable() {
        if (set_) ::unsetenv(name_);
    }

private:
    const char* name_;
    bool set_ = false;
};

bool isSet(const char* variable) {
    const char* value = std::getenv(variable);
    return value != nullptr && *value != '\0';
}

/// SwiftShader comes with Chromium and Chrome, out of the loader's sight.
std::string swiftShaderManifest() {
    for (const char* path :
         {"/usr/lib/chromium/vk_swiftshader_icd.json", "/usr/lib/chromium-browser/vk_swiftshader_icd.json",
          "/usr/lib64/chromium-browser/vk_swiftshader_icd.json", "/opt/google/chrome/vk_swiftshader_icd.json"}) {
        std::error_code ignored;
        if (std::filesystem::exists(path, ignored)) return path;
    }
    return {};
}

bool hasValidationLayer() {
    uint32_t count = 0;
    if (vkEnumerateInstanceLayerProperties(&count, nullptr) != VK_SUCCESS) return false;
    std::vector<VkLayerProperties> layers(count);
    if (vkEnumerateInstanceLayerProperties(&count, layers.data()) != VK_SUCCESS) return false;
    for (const VkLayerProperties& layer : layers)
        if (std::strcmp(layer.layerName, "VK_LAYER_KHRONOS_validation") == 0) return true;
    return false;
}

VkInstance createInstance(bool validate) {
    VkApplicationInfo application = vk::init<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
    application.pApplicationName = "raig";
    application.apiVersion = VK_API_VERSION_1_2;  // 1.1 is used; 1.2 lets the driver be told its name and float controls

    const char* layer = "VK_LAYER_KHRONOS_validation";
    const char* extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features = vk::init<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &enabled;
    VkDebugUtilsMessengerCreateInfoEXT messenger =
        vk::init<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = onMessage;

    VkInstanceCreateInfo create = vk::init<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
    create.pApplicationInfo = &application;
    if (validate) {
        create.pNext = &features;
        create.enabledLayerCount = 1;
        create.ppEnabledLayerNames = &layer;
        create.enabledExtensionCount = 2;
        create.ppEnabledExtensionNames = extensions;
    }
    VkInstance made = VK_NULL_HANDLE;
    if (vkCreateInstance(&create, nullptr, &made) != VK_SUCCESS) return VK_NULL_HANDLE;  // no driver at all, usually
    volkLoadInstanceOnly(made);
    if (validate) {
        VkDebugUtilsMessengerEXT unused = VK_NULL_HANDLE;  // lives as long as the instance
        vk::check(vkCreateDebugUtilsMessengerEXT(made, &messenger, nullptr, &unused), "listen to the validation layer");
    }
    return made;
}

VkInstance loadInstance() {
    if (volkInitialize() != VK_SUCCESS) return VK_NULL_HANDLE;
    // A loader of Vulkan 1.0 has no such function, and only devices of 1.0.
    if (vkEnumerateInstanceVersion == nullptr) return VK_NULL_HANDLE;

    std::optional<ScopedVariable> drivers;
    const std::string manifest = swiftShaderManifest();
    if (!manifest.empty() && !isSet("VK_DRIVER_FILES") && !isSet("VK_ICD_FILENAMES"))
        drivers.emplace("VK_ADD_DRIVER_FILES", manifest);
    // Mesa's device-selection layer connects to X and Wayland, and complains where there are none.
    std::optional<ScopedVariable> selection;
    if (!isSet("MESA_VK_DEVICE_SELECT")) selection.emplace("NODEVICE_SELECT", "1");

    const char* wanted = std::getenv("RAIG_VALIDATION");
    const bool validate = wanted != nullptr && std::strcmp(wanted, "1") == 0;
    validating = validate && hasValidationLayer();
    if (validate && !validating) log::warn("RAIG_VALIDATION=1, but VK_LAYER_KHRONOS_validation is not installed");
    return createInstance(validating);
}

}  // namespace

namespace vk {

void check(VkResult result, const char* what) {
    switch (result) {
        case VK_SUCCESS:
            return;
        case VK_ERROR_OUT_OF_HOST_MEMORY:
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            throw limitError("the device cannot {}: out of memory; a smaller scene or picture may fit", what);
        case VK_ERROR_DEVICE_LOST:
            throw deviceError("the device was lost and cannot {}; --device names another", what);
        default:
            throw deviceError("the device cannot {} (Vulkan result {}); --device names another", what,
                              static_cast<int>(result));
    }
}

VkInstance instance() {
    // Never destroyed: drivers may be torn down before our statics are, and the end of the process does it anyway.
    static const VkInstance made = loadInstance();
    return made;
}

}  // namespace vk

std::vector<std::string> validationMessages() {
    const std::lock_guard guard(messageLock);
    return messages;
}

bool validationActive() {
    vk::instance();
    return validating;
}

}  // namespace raig
