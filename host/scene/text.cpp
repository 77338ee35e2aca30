#include "scene/text.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>

namespace raig::text {

namespace {

bool isBlank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

char toLower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// How many characters the line end at the start of `text` has; 0 if there is none.
size_t lineEndLength(std::string_view text) {
    if (text.starts_with("\r\n")) return 2;
    return text.starts_with('\n') || text.starts_with('\r') ? 1 : 0;
}

/// How many characters the backslash and line end at the start of `text` have; 0 if there is no such pair.
size_t continuationLength(std::string_view text) {
    if (!text.starts_with('\\')) return 0;
    const size_t end = lineEndLength(text.substr(1));
    return end == 0 ? 0 : end + 1;
}

/// What Microsoft's C library prints for what is no number: 1.#INF, -1.#IND, 1.#QNAN00.
std::optional<float> parseMicrosoftSpecial(std::string_view word) {
    const bool negative = word.starts_with('-');
    if (negative) word.remove_prefix(1);
    if (!word.starts_with("1.#")) return std::nullopt;
    word.remove_prefix(3);
    const float sign = negative ? -1.0f : 1.0f;
    if (word.starts_with("INF")) return sign * std::numeric_limits<float>::infinity();
    if (word.starts_with("IND") || word.starts_with("QNAN") || word.starts_with("SNAN"))
        return std::numeric_limits<float>::quiet_NaN();
    return std::nullopt;
}

}  // namespace

std::string_view checkText(std::span<const std::byte> bytes, const std::string& place) {
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
        throw inputError(place, "is UTF-16 text; save it as UTF-8 or ASCII");
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    const size_t nul = text.find('\0');
    if (nul != std::string_view::npos) {
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n');
        throw inputError(fmt::format("{}:{}", place, line), "is not text: there is a NUL character");
    }
    return text;
}

std::optional<float> parseFloat(std::string_view word) {
    const std::string_view whole = word;
    if (word.starts_with('+')) {
        word.remove_prefix(1);
        if (word.starts_with('-')) return std::nullopt;
    }
    float value = 0.0f;
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (stop != end || error == std::errc::invalid_argument) return parseMicrosoftSpecial(whole);
    // from_chars leaves the value alone when it is out of range; strtof says on which side.
    if (error == std::errc::result_out_of_range) return std::strtof(std::string(word).c_str(), nullptr);
    return value;
}

std::optional<int64_t> parseInteger(std::string_view word) {
    if (word.starts_with('+')) {
        word.remove_prefix(1);
        if (word.starts_with('-')) return std::nullopt;
    }
    int64_t value = 0;
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (stop != end || error != std::errc()) return std::nullopt;
    return value;
}

std::string quoted(std::string_view word) {
    std::string shown(word.substr(0, 40));
    for (char& c : shown)
        if (c < ' ' || c > '~') c = '?';
    return "'" + shown + (word.size() > 40 ? "...'" : "'");
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
    while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
    return text;
}

bool equalsIgnoringCase(std::string_view a, std::string_view b) {
    return std::ranges::equal(a, b, {}, toLower, toLower);
}

void Words::skipBlanks() {
    while (!left_.empty()) {
        if (const size_t continuation = continuationLength(left_); continuation > 0) {
            ++line_;
            left_.remove_prefix(continuation);
        } else if (const size_t end = lineEndLength(left_); end > 0) {
            ++line_;
            left_.remove_prefix(end);
        } else if (isBlank(left_.front())) {
            left_.remove_prefix(1);
        } else {
            return;
        }
    }
}

std::string_view Words::next() {
    skipBlanks();
    size_t length = 0;
    while (length < left_.size() && !isBlank(left_[length]) &&
           (left_[length] != '\\' || continuationLength(left_.substr(length)) == 0))
        ++length;
    const std::string_view word = left_.substr(0, length);
    left_.remove_prefix(length);
    return word;
}

std::string joinedLines(std::string_view statement) {
    std::string joined;
    while (!statement.empty()) {
        const size_t continuation = continuationLength(statement);
        joined += continuation > 0 ? ' ' : statement.front();
        statement.remove_prefix(std::max<size_t>(continuation, 1));
    }
    return joined;
}

void Words::skipLine() {
    left_.remove_prefix(std::min(left_.find_first_of("\r\n"), left_.size()));
}

std::optional<std::string_view> Statements::next() {
    if (left_.empty()) return std::nullopt;
    line_ = nextLine_;
    const bool isComment = trimmed(left_.substr(0, left_.find_first_of("\r\n"))).starts_with('#');
    size_t length = 0;
    while (length < left_.size()) {
        const size_t end = lineEndLength(left_.substr(length));
        if (end > 0) {
            ++nextLine_;
            const bool continues = !isComment && length > 0 && left_[length - 1] == '\\';
            if (!continues) {
                const std::string_view statement = left_.substr(0, length);
                left_.remove_prefix(length + end);
                return statement;
            }
            length += end;
        } else {
            ++length;
        }
    }
    const std::string_view last = left_;
    left_ = {};
    return last;
}

}  // namespace raig::text
