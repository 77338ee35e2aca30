/// Compiled pipelines kept between runs, in the user's cache folder. Whatever goes wrong there only costs time.
#pragma once

#include "device/vulkan.hpp"

namespace raig::vk {

/// The file for devices of `key`: in $XDG_CACHE_HOME/raig or ~/.cache/raig. Empty if there is neither.
std::filesystem::path cacheFile(const std::string& key);

/// What encodeCache was given, if `file` is whole and of the same key.
std::optional<std::vector<std::byte>> decodeCache(std::span<const std::byte> file, const std::string& key);
std::vector<std::byte> encodeCache(std::span<const std::byte> blob, const std::string& key);

/// Makes state.cache, filled from state.cacheFile if that holds something usable.
void openCache(Device::State& state);
/// Writes the file if a pipeline was added, and destroys the cache.
void closeCache(Device::State& state);

}  // namespace raig::vk
