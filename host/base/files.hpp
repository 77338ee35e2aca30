/// Files read whole and written whole: a reader never sees half of what we write.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace raig {

/// Reads a whole file. Throws inputError if it cannot be opened or read, is a folder, or exceeds `maxBytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, size_t maxBytes = size_t{16} << 30);

/// Writes to a new file beside `path`, then renames it over `path`: never half a file. What a link points to is replaced,
/// not the link; a device or a pipe is written to. Throws an Error (badInput, as the path is the user's) if that fails;
/// nothing is left behind then.
void writeFileAtomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
/// The same of a file in several pieces.
void writeFileAtomically(const std::filesystem::path& path, std::span<const std::span<const std::byte>> pieces);

}  // namespace raig
