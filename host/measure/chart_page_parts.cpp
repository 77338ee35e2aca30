#include "measure/chart_page_parts.hpp"

#include "measure/junit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>

namespace raig::page {

namespace {

/// "1,234,567"
std::string grouped(std::string digits) {
    for (size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
    return digits;
}

/// "1.234·10⁻⁵"
std::string scientific(double size) {
    static constexpr const char* raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    const std::string text = fmt::format("{:.3e}", size);
    const size_t e = text.find('e');
    const int exponent = std::stoi(text.substr(e + 1));
    std::string result = fmt::format("{:g}·10{}", std::stod(text.substr(0, e)), exponent < 0 ? "⁻" : "");
    for (const char digit : std::to_string(std::abs(exponent))) result += raised[digit - '0'];
    return result;
}

std::string plain(const Json& value) {
    if (value.is_number()) return number(value.get<double>());
    if (value.is_string()) return value.get<std::string>();
    if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
    return value.is_null() ? "–" : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string cellMarkup(const char* element, const std::string& kind, const std::string& attributes,
                       const std::string& content) {
    return fmt::format("<{0}{1}{2}>{3}</{0}>", element, kind.empty() ? "" : fmt::format(" class=\"{}\"", kind), attributes,
                       content);
}

std::string joined(const std::string& first, const std::string& second) {
    return first.empty() || second.empty() ? first + second : first + " " + second;
}

std::string cellOf(const Cell& cell, bool isAmongTexts) {
    // A number that is not finite sorts as null does, with which JSON says it.
    const bool isNumber = cell.content.is_number() && std::isfinite(cell.content.get<double>());
    const bool isText = cell.content.is_string() || cell.content.is_boolean();
    const std::string sorted = isNumber ? fmt::format(" data-value=\"{}\"", cell.content.get<double>()) : "";
    const std::string kind = isNumber ? (cell.content.get<double>() == 0.0 ? "zero" : "") : isText ? "" : "none";
    const std::string side = isAmongTexts ? "what" : "";
    return cellMarkup("td", joined(joined(kind, side), cell.mark), sorted, value(cell.content));
}

}  // namespace

std::string number(double value) {
    if (!std::isfinite(value)) return "–";
    if (value == 0.0) return "0";
    const std::string sign = value < 0.0 ? "−" : "";
    const double size = std::abs(value);
    if (size >= 1e15 || size < 1e-4) return sign + scientific(size);
    if (size == std::floor(size) || size >= 999.95) return sign + grouped(fmt::format("{:.0f}", size));
    return sign + fmt::format("{:.4g}", size);
}

std::string value(const Json& value) {
    return escapedMarkup(plain(value));
}

Json member(const Json& object, const std::string& name) {
    return object.contains(name) ? object[name] : Json();
}

std::string count(size_t many, std::string_view one) {
    return fmt::format("{} {}{}", grouped(std::to_string(many)), one, many == 1 ? "" : "s");
}

std::string dataUri(std::string_view type, std::span<const std::byte> bytes) {
    static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text = fmt::format("data:{};base64,", type);
    text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
    for (size_t at = 0; at < bytes.size(); at += 3) {
        const size_t left = std::min<size_t>(3, bytes.size() - at);
        uint32_t bits = 0;
        for (size_t i = 0; i < 3; ++i) bits = bits << 8 | (i < left ? std::to_integer<uint32_t>(bytes[at + i]) : 0u);
        for (size_t i = 0; i < 4; ++i) text += i <= left ? digits[bits >> (18 - 6 * i) & 63u] : '=';
    }
    return text;
}

std::string dataUri(std::string_view type, std::string_view bytes) {
    return dataUri(type, std::as_bytes(std::span(bytes.data(), bytes.size())));
}

std::string fileLink(const std::string& name, const std::string& text) {
    std::string address = "./";
    for (const char c : name) {
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
        address += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return fmt::format("<a href=\"{}\">{}</a>", address, escapedMarkup(text));
}

std::string table(const std::string& label, const std::vector<std::string>& columns,
                  const std::vector<std::vector<Cell>>& rows) {
    std::string markup = fmt::format(
        "<div class=\"wide\" role=\"region\" tabindex=\"0\" aria-label=\"{}\"><table class=\"sorts\"><thead><tr>",
        escapedMarkup(label));
    std::vector<bool> hasText(columns.size());
    for (size_t i = 0; i < columns.size(); ++i) {
        hasText[i] = std::any_of(rows.begin(), rows.end(), [&](const auto& row) { return row[i].content.is_string(); });
        markup += cellMarkup("th", hasText[i] ? "what" : "", " scope=\"col\"", escapedMarkup(columns[i]));
    }
    markup += "</tr></thead><tbody>\n";
    for (const std::vector<Cell>& row : rows) {
        markup += "<tr>";
        for (size_t i = 0; i < columns.size(); ++i) markup += cellOf(row[i], hasText[i]);
        markup += "</tr>\n";
    }
    return markup + "</tbody></table></div>\n";
}

std::string prose(const std::string& text) {
    static const std::regex power(R"(\^(?:\(([^()&]{1,40})\)|(-?[0-9]{1,9})))");
    return std::regex_replace(escapedMarkup(text), power, "<sup>$1$2</sup>");
}

Json heldOf(const std::vector<ChartPoint>& points) {
    Json held = Json::object();
    if (points.size() < 2) return held;
    for (const auto& [name, content] : points.front().settings.items())
        if (std::all_of(points.begin(), points.end(), [&name = name, &content = content](const ChartPoint& point) {
                return point.settings.contains(name) && point.settings[name] == content;
            }))
            held[name] = content;
    return held;
}

std::string describe(const Json& settings, const Json& without) {
    if (settings.contains("label") && settings["label"].is_string()) return settings["label"].get<std::string>();
    std::string text;
    for (const auto& [name, setting] : settings.items())
        if (!without.contains(name))
            text += fmt::format("{}{}{}", text.empty() ? "" : ", ", name == "accel" ? "" : name + " ", plain(setting));
    return text;
}

std::string describe(const Breach& breach) {
    return (breach.scene.empty() ? "" : "<b>" + escapedMarkup(breach.scene) + "</b>: ") + prose(breach.text);
}

}  // namespace raig::page
