#include "base/files.hpp"
#include "scene/gltf_document.hpp"

#include <algorithm>
#include <array>

namespace raig::gltf {

namespace {

constexpr uint8_t notBase64 = 255;

constexpr std::array<uint8_t, 256> base64Values = [] {
    std::array<uint8_t, 256> values{};
    values.fill(notBase64);
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < alphabet.size(); ++i) values[static_cast<uint8_t>(alphabet[i])] = static_cast<uint8_t>(i);
    return values;
}();

/// RFC 4648 without line breaks; the padding may be missing.
std::vector<std::byte> decodeBase64(std::string_view text, const std::string& place) {
    for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
    if (text.size() % 4 == 1) throw inputError(place, "its base64 data is cut short");
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    uint32_t bits = 0;
    int bitCount = 0;
    for (const char c : text) {
        const uint8_t value = base64Values[static_cast<uint8_t>(c)];
        if (value == notBase64) throw inputError(place, "its base64 data holds a character that is not base64");
        bits = bits << 6 | value;
        bitCount += 6;
        if (bitCount < 8) continue;
        bitCount -= 8;
        bytes.push_back(static_cast<std::byte>(bits >> bitCount & 0xff));
    }
    return bytes;
}

int hexValue(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/// Undoes %XX; a stray % stays as it is.
std::string decodePercent(std::string_view text) {
    std::string decoded;
    for (size_t i = 0; i < text.size(); ++i) {
        const bool isEscape =
            text[i] == '%' && i + 2 < text.size() && hexValue(text[i + 1]) >= 0 && hexValue(text[i + 2]) >= 0;
        decoded += isEscape ? static_cast<char>(hexValue(text[i + 1]) * 16 + hexValue(text[i + 2])) : text[i];
        if (isEscape) i += 2;
    }
    return decoded;
}

std::vector<std::byte> decodeDataUri(std::string_view uri, const std::string& place) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) throw inputError(place, "its data URI has no comma");
    const std::string_view body = uri.substr(comma + 1);
    if (uri.substr(0, comma).ends_with(";base64")) return decodeBase64(body, place);
    const std::string decoded = decodePercent(body);
    const Bytes bytes = std::as_bytes(std::span(decoded));
    return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<std::byte> readUri(const std::string& uri, const std::filesystem::path& folder, const std::string& place) {
    if (uri.starts_with("data:")) return decodeDataUri(uri, place);
    const std::string name = decodePercent(uri);
    const bool isPlain = std::none_of(name.begin(), name.end(), [](char c) { return (c >= 0 && c < 32) || c == 127; });
    if (name.empty() || !isPlain)
        throw inputError(place, "its URI '{}' is empty or holds control characters", printable(uri));
    const size_t colon = name.find(':');
    if (colon != std::string::npos && colon < name.find('/'))
        throw inputError(place, "cannot read '{}': only files beside the scene and data URIs are read", printable(uri));
    const std::filesystem::path relative = std::filesystem::path(name).lexically_normal();
    if (relative.is_absolute() || *relative.begin() == "..")
        throw inputError(place, "refuses to read '{}': it lies outside the scene's folder", printable(uri));
    try {
        return readFile(folder / relative);
    } catch (const Error& problem) {
        throw Error(problem.exitCode, place + ": " + problem.what());
    }
}

}  // namespace raig::gltf
