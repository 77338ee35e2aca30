#include "measure/junit.hpp"

#include <fmt/format.h>

namespace raig {

namespace {

/// The length of the UTF-8 sequence at `at`: 0 if there is none. Surrogates and overlong forms are none.
size_t sequenceAt(const std::string& text, size_t at) {
    const auto byte = [&](size_t i) { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u; };
    const unsigned first = byte(0);
    const size_t length = first < 0x80 ? 1 : first >= 0xc2 && first < 0xe0 ? 2 : first >= 0xe0 && first < 0xf0 ? 3 : 0;
    for (size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xc0u) != 0x80u) return 0;
    if (length == 3) {
        const unsigned code = (first & 0x0fu) << 12 | (byte(1) & 0x3fu) << 6 | (byte(2) & 0x3fu);
        if (code < 0x800 || (code >= 0xd800 && code < 0xe000) || code >= 0xfffe) return 0;
    }
    if (first < 0xf0 || first > 0xf4) return length;
    for (size_t i = 1; i < 4; ++i)
        if ((byte(i) & 0xc0u) != 0x80u) return 0;
    if ((first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) >= 0x90)) return 0;
    return 4;
}

}  // namespace

std::string escapedMarkup(const std::string& text) {
    std::string escaped;
    for (size_t at = 0; at < text.size();) {
        const size_t length = sequenceAt(text, at);
        const char c = text[at];
        if (length == 0)
            escaped += '?';
        else if (length > 1)
            escaped.append(text, at, length);
        else if (c == '&')
            escaped += "&amp;";
        else if (c == '<')
            escaped += "&lt;";
        else if (c == '>')
            escaped += "&gt;";
        else if (c == '"')
            escaped += "&quot;";
        else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            escaped += ' ';
        else
            escaped += c;
        at += length == 0 ? 1 : length;
    }
    return escaped;
}

std::string junitXml(const std::string& suite, const std::vector<JUnitCase>& cases) {
    size_t failures = 0;
    double seconds = 0.0;
    for (const JUnitCase& one : cases) {
        failures += !one.failure.empty();
        seconds += one.seconds;
    }
    const std::string counts =
        fmt::format(R"(tests="{}" failures="{}" errors="0" skipped="0" time="{:.3f}")", cases.size(), failures, seconds);
    std::string xml = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {0}>\n"
        "  <testsuite name=\"{1}\" {0}>\n",
        counts, escapedMarkup(suite));
    for (const JUnitCase& one : cases) {
        xml += fmt::format(R"(    <testcase classname="{}" name="{}" time="{:.3f}")", escapedMarkup(one.group),
                           escapedMarkup(one.name), one.seconds);
        xml += one.failure.empty() ? "/>\n"
                                   : fmt::format(">\n      <failure message=\"{0}\">{0}</failure>\n    </testcase>\n",
                                                 escapedMarkup(one.failure));
    }
    return xml + "  </testsuite>\n</testsuites>\n";
}

}  // namespace raig
