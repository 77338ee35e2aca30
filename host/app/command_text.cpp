#include "app/command_text.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace raig {

std::string quoted(const std::string& text) {
    const bool isPlain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || std::string_view("-_./:=,").find(static_cast<char>(c)) != std::string_view::npos;
    });
    if (isPlain) return text;
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
    return word + "'";
}

}  // namespace raig
