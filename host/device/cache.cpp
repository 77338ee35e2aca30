#include "device/cache.hpp"

#include "base/files.hpp"
#include "device/kept.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <mutex>

namespace raig::vk {

namespace {

/// Before the driver's blob, which drivers check only in part: a damaged one could crash them.
struct Header {
    std::array<char, 8> magic{'r', 'a', 'i', 'g', 'p', 'c', '0', '1'};
    uint64_t keyHash = 0;
    uint64_t blobBytes = 0;
    uint64_t blobHash = 0;
};
static_assert(sizeof(Header) == 32);

constexpr size_t largestFile = size_t{64} << 20;

/// FNV-1a, 64 bits [Fowler, Noll and Vo 1991]: against damage, not against malice.
uint64_t hash(std::span<const std::byte> bytes) {
    uint64_t value = 0xcbf29ce484222325u;
    for (const std::byte byte : bytes) value = (value ^ static_cast<uint64_t>(byte)) * 0x100000001b3u;
    return value;
}

uint64_t hash(const std::string& text) {
    return hash(std::as_bytes(std::span(text)));
}

void save(const std::filesystem::path& path, std::span<const std::byte> file) {
    static std::mutex lock;  // two devices of one process would share the temporary file's name
    const std::lock_guard guard(lock);
    std::error_code ignored;
    std::filesystem::create_directories(path.parent_path(), ignored);
    try {
        writeFileAtomically(path, file);
    } catch (const Error&) {
        // A cache folder that cannot be written only means compiling again.
    }
}

std::optional<std::vector<std::byte>> load(const std::filesystem::path& path, const std::string& key) {
    std::error_code ignored;
    if (path.empty() || !std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
    try {
        return decodeCache(readFile(path, largestFile), key);
    } catch (const Error&) {
        return std::nullopt;  // unreadable: as if it were not there
    }
}

/// What is kept besides pipelines lies in their folder.
std::filesystem::path keptFile(const Device::State& state, const std::string& key) {
    if (state.cacheFile.empty()) return {};
    return state.cacheFile.parent_path() / fmt::format("kept-{:016x}.bin", hash(key));
}

std::string keptKey(const Device::State& state, std::string_view what) { return fmt::format("{} {}", what, state.cacheKey); }

}  // namespace

std::filesystem::path cacheFile(const std::string& key) {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    const char* home = std::getenv("HOME");
    std::filesystem::path folder;
    if (cache && cache[0] == '/')  // the XDG specification ignores relative paths
        folder = cache;
    else if (home && home[0] == '/')
        folder = std::filesystem::path(home) / ".cache";
    else
        return {};
    return folder / "raig" / fmt::format("pipelines-{:016x}.bin", hash(key));
}

std::vector<std::byte> encodeCache(std::span<const std::byte> blob, const std::string& key) {
    Header header;
    header.keyHash = hash(key);
    header.blobBytes = blob.size();
    header.blobHash = hash(blob);
    std::vector<std::byte> file(sizeof(header) + blob.size());
    std::memcpy(file.data(), &header, sizeof(header));
    if (!blob.empty()) std::memcpy(file.data() + sizeof(header), blob.data(), blob.size());
    return file;
}

std::optional<std::vector<std::byte>> decodeCache(std::span<const std::byte> file, const std::string& key) {
    Header header;
    const Header expected;
    if (file.size() < sizeof(header)) return std::nullopt;
    std::memcpy(&header, file.data(), sizeof(header));
    const std::span<const std::byte> blob = file.subspan(sizeof(header));
    if (header.magic != expected.magic || header.keyHash != hash(key) || header.blobBytes != blob.size() ||
        header.blobHash != hash(blob))
        return std::nullopt;
    return std::vector<std::byte>(blob.begin(), blob.end());
}

void openCache(Device::State& state) {
    const std::vector<std::byte> blob = load(state.cacheFile, state.cacheKey).value_or(std::vector<std::byte>());
    state.cacheHash = hash(blob);
    VkPipelineCacheCreateInfo create = vk::init<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
    create.initialDataSize = blob.size();
    create.pInitialData = blob.data();
    if (state.call.vkCreatePipelineCache(state.handle, &create, nullptr, &state.cache) == VK_SUCCESS) return;
    create.initialDataSize = 0;
    check(state.call.vkCreatePipelineCache(state.handle, &create, nullptr, &state.cache), "keep compiled kernels");
}

void closeCache(Device::State& state) {
    if (state.cache == VK_NULL_HANDLE) return;
    size_t size = 0;
    if (state.cacheGrew && !state.cacheFile.empty() &&
        state.call.vkGetPipelineCacheData(state.handle, state.cache, &size, nullptr) == VK_SUCCESS &&
        size <= largestFile / 2) {
        std::vector<std::byte> blob(size);
        if (state.call.vkGetPipelineCacheData(state.handle, state.cache, &size, blob.data()) == VK_SUCCESS) {
            blob.resize(size);
            if (hash(blob) != state.cacheHash) save(state.cacheFile, encodeCache(blob, state.cacheKey));
        }
    }
    state.call.vkDestroyPipelineCache(state.handle, state.cache, nullptr);
}

}  // namespace raig::vk

namespace raig {

std::optional<std::vector<std::byte>> readKept(const Device& device, std::string_view what) {
    const std::string key = vk::keptKey(device.state(), what);
    return vk::load(vk::keptFile(device.state(), key), key);
}

void writeKept(const Device& device, std::string_view what, std::span<const std::byte> bytes) {
    const std::string key = vk::keptKey(device.state(), what);
    const std::filesystem::path path = vk::keptFile(device.state(), key);
    if (!path.empty()) vk::save(path, vk::encodeCache(bytes, key));
}

}  // namespace raig
