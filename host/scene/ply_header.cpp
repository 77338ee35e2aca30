#include "scene/ply_header.hpp"

#include "base/error.hpp"
#include "scene/text.hpp"

#include <array>
#include <optional>

namespace raig::ply {

namespace {

constexpr size_t longestHeader = size_t{1} << 20;

std::optional<Type> parseType(std::string_view word) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 8> names{{{"char", "int8"},
                                                                                         {"uchar", "uint8"},
                                                                                         {"short", "int16"},
                                                                                         {"ushort", "uint16"},
                                                                                         {"int", "int32"},
                                                                                         {"uint", "uint32"},
                                                                                         {"float", "float32"},
                                                                                         {"double", "float64"}}};
    for (size_t i = 0; i < names.size(); ++i)
        if (word == names[i].first || word == names[i].second) return static_cast<Type>(i);
    return std::nullopt;
}

class HeaderReader {
public:
    HeaderReader(std::string_view content, std::string place) : content_(content), place_(std::move(place)) {}

    Header read() {
        if (text::trimmed(nextLine()) != "ply") throw inputError(place_, "is no PLY file: it does not begin with 'ply'");
        bool hasFormat = false;
        while (true) {
            text::Words words(nextLine());
            const std::string_view key = words.next();
            if (key == "end_header") break;
            if (key == "format") {
                readFormat(words.next());
                hasFormat = true;
            } else if (key == "element") {
                readElement(words);
            } else if (key == "property") {
                readProperty(words);
            } else if (!key.empty() && key != "comment" && key != "obj_info") {
                throw fault("{} is no statement of a PLY header", text::quoted(key));
            }
        }
        if (!hasFormat) throw fault("the header has no 'format'");
        header_.bodyOffset = at_;
        header_.bodyLine = line_ + 1;
        return std::move(header_);
    }

private:
    template <class... Args>
    [[nodiscard]] Error fault(fmt::format_string<Args...> format, Args&&... args) const {
        return inputError(fmt::format("{}:{}", place_, line_), format, std::forward<Args>(args)...);
    }

    /// The next line. Lines end as the first one does, so that a data byte of 10 after CR is not taken for a line end.
    std::string_view nextLine() {
        if (line_ == 0) {
            const size_t end = std::min(content_.find_first_of("\r\n"), content_.size());
            lineEnd_ = content_.substr(end, content_.substr(end).starts_with("\r\n") ? 2 : 1);
        }
        ++line_;
        const size_t end = lineEnd_.empty() ? std::string_view::npos : content_.substr(0, longestHeader).find(lineEnd_, at_);
        if (end == std::string_view::npos)
            throw inputError(place_, "is no PLY file, or cut off: its header has no 'end_header'");
        const std::string_view line = content_.substr(at_, end - at_);
        at_ = end + lineEnd_.size();
        return line;
    }

    void readFormat(std::string_view word) {
        if (word == "ascii")
            header_.encoding = Encoding::ascii;
        else if (word == "binary_little_endian")
            header_.encoding = Encoding::binaryLittleEndian;
        else if (word == "binary_big_endian")
            header_.encoding = Encoding::binaryBigEndian;
        else
            throw fault("the format {} is unknown (expected: ascii, binary_little_endian or binary_big_endian)",
                        text::quoted(word));
    }

    void readElement(text::Words& words) {
        Element element;
        element.name = words.next();
        const std::string_view word = words.next();
        const auto count = text::parseInteger(word);
        if (element.name.empty() || !count || *count < 0) throw fault("{} is not a number of elements", text::quoted(word));
        for (const Element& other : header_.elements)
            if (other.name == element.name) throw fault("the element {} is declared twice", text::quoted(element.name));
        element.count = static_cast<uint64_t>(*count);
        header_.elements.push_back(std::move(element));
    }

    void readProperty(text::Words& words) {
        if (header_.elements.empty()) throw fault("a property stands before any element");
        Property property;
        std::string_view word = words.next();
        if (word == "list") {
            property.isList = true;
            word = words.next();
            const auto countType = parseType(word);
            if (!countType || !isInteger(*countType)) throw fault("{} is no type for a list's length", text::quoted(word));
            property.countType = *countType;
            word = words.next();
        }
        const auto type = parseType(word);
        if (!type) throw fault("the type {} is unknown", text::quoted(word));
        property.type = *type;
        property.name = words.next();
        if (property.name.empty()) throw fault("a property without a name");
        header_.elements.back().properties.push_back(std::move(property));
    }

    std::string_view content_;
    std::string place_;
    std::string_view lineEnd_;
    size_t at_ = 0;
    size_t line_ = 0;
    Header header_;
};

}  // namespace

size_t sizeOf(Type type) {
    static constexpr std::array<size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<size_t>(type)];
}

Header readHeader(std::string_view content, const std::string& place) {
    return HeaderReader(content, place).read();
}

size_t leastSize(const Element& element, Encoding encoding) {
    // In text, every value takes a character and all but the file's last a blank.
    if (encoding == Encoding::ascii) return 2 * element.properties.size();
    size_t size = 0;
    for (const Property& property : element.properties) size += sizeOf(property.isList ? property.countType : property.type);
    return size;
}

}  // namespace raig::ply
