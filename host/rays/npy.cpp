#include "rays/npy.hpp"

#include "base/error.hpp"
#include "base/files.hpp"

#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

namespace raig {

static_assert(std::endian::native == std::endian::little, "arrays are copied to and from little-endian files as they are");

namespace {

constexpr std::string_view magic("\x93NUMPY", 6);

/// What the header's dictionary says. `descr` is the text between the quotes, or the whole literal of a structured dtype.
struct Header {
    std::optional<std::string> descr;
    std::optional<bool> fortranOrder;
    std::optional<std::vector<uint64_t>> shape;
};

/// A strict parser of the one Python dictionary literal a header holds: three keys, each once, in any order.
class HeaderParser {
public:
    HeaderParser(std::string_view header, const std::string& file) : text(header), place(file) {}

    Header parse() {
        Header header;
        expect('{');
        while (!accept('}')) {
            const std::string key = quoted();
            expect(':');
            if (key == "descr" && !header.descr)
                header.descr = descr();
            else if (key == "fortran_order" && !header.fortranOrder)
                header.fortranOrder = boolean();
            else if (key == "shape" && !header.shape)
                header.shape = tuple();
            else
                throw fault("an unknown or repeated key");
            if (!accept(',')) {
                expect('}');
                break;
            }
        }
        skipSpace();
        if (at != text.size()) throw fault("more after the dictionary");
        if (!header.descr || !header.fortranOrder || !header.shape) throw fault("no descr, fortran_order or shape");
        return header;
    }

private:
    Error fault(const char* what) const {
        return inputError(place, "is damaged: its NumPy header has {} at character {}", what, at);
    }

    void skipSpace() {
        while (at < text.size() && (text[at] == ' ' || text[at] == '\n')) ++at;
    }
    bool accept(char c) {
        skipSpace();
        if (at >= text.size() || text[at] != c) return false;
        ++at;
        return true;
    }
    void expect(char c) {
        if (!accept(c)) throw fault(fmt::format("no '{}'", c).c_str());
    }
    bool acceptWord(std::string_view word) {
        skipSpace();
        if (!text.substr(at).starts_with(word)) return false;
        at += word.size();
        return true;
    }
    std::string quoted() {
        skipSpace();
        const char quote = at < text.size() ? text[at] : '\0';
        if (quote != '\'' && quote != '"') throw fault("no string");
        const size_t end = text.find(quote, at + 1);
        if (end == std::string_view::npos) throw fault("a string without an end");
        const std::string inside(text.substr(at + 1, end - at - 1));
        at = end + 1;
        return inside;
    }
    /// A dtype: a string, or a list of fields, which is taken as it stands, up to its closing bracket.
    std::string descr() {
        skipSpace();
        if (at >= text.size() || text[at] != '[') return quoted();
        const size_t begin = at;
        for (size_t depth = 0; at < text.size(); ++at) {
            if (text[at] == '[') ++depth;
            if (text[at] == ']' && --depth == 0) return std::string(text.substr(begin, ++at - begin));
        }
        throw fault("a list without an end");
    }
    bool boolean() {
        if (acceptWord("True")) return true;
        if (acceptWord("False")) return false;
        throw fault("neither True nor False");
    }
    std::vector<uint64_t> tuple() {
        std::vector<uint64_t> numbers;
        expect('(');
        while (!accept(')')) {
            skipSpace();
            uint64_t number = 0;
            const char* begin = text.data() + at;
            const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
            if (error != std::errc()) throw fault("no whole number");
            at += static_cast<size_t>(end - begin);
            numbers.push_back(number);
            const bool comma = accept(',');
            if (numbers.size() == 1 && !comma) throw fault("a number in brackets, which is no tuple");
            if (!comma) {
                expect(')');
                break;
            }
        }
        return numbers;
    }

    std::string_view text;
    const std::string& place;
    size_t at = 0;
};

/// The header's text, and where the array begins.
std::pair<std::string_view, size_t> splitHeader(std::span<const std::byte> bytes, const std::string& place) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!text.starts_with(magic)) throw inputError(place, "is no NumPy .npy file: write it with numpy.save");
    if (text.size() < 10) throw inputError(place, "is cut short: its NumPy header does not end");
    const int major = static_cast<unsigned char>(text[6]), minor = static_cast<unsigned char>(text[7]);
    if (major < 1 || major > 3 || minor != 0)
        throw inputError(place, "is of .npy version {}.{}; 1.0, 2.0 and 3.0 are read", major, minor);
    const size_t lengthBytes = major == 1 ? 2 : 4;
    uint32_t length = 0;
    if (text.size() >= 8 + lengthBytes) std::memcpy(&length, text.data() + 8, lengthBytes);
    const size_t begin = 8 + lengthBytes;
    if (text.size() < begin || length > text.size() - begin)
        throw inputError(place, "is cut short: its NumPy header does not end");
    return {text.substr(begin, length), begin + length};
}

/// The shape as Python writes it: (), (3,), (3, 8).
std::string describe(const std::vector<uint64_t>& shape) {
    std::string text = "(";
    for (size_t i = 0; i < shape.size(); ++i) text += fmt::format("{}{}", i == 0 ? "" : ", ", shape[i]);
    return text + (shape.size() == 1 ? ",)" : ")");
}

/// Magic, version 1.0 and the dictionary, padded with blanks so that the array begins at a multiple of 64.
std::string makeHeader(const std::string& dictionary) {
    const size_t before = magic.size() + 4;
    const size_t whole = (before + dictionary.size() + 1 + 63) / 64 * 64;
    const size_t length = whole - before;
    RAIG_CHECK_OP(length, <=, 65535u);
    std::string header(magic);
    header += {'\x01', '\x00', static_cast<char>(length & 0xff), static_cast<char>(length >> 8)};
    header += dictionary;
    header.append(whole - header.size() - 1, ' ');
    return header + '\n';
}

std::vector<std::byte> join(const std::string& header, const void* data, size_t size) {
    std::vector<std::byte> bytes(header.size() + size);
    std::memcpy(bytes.data(), header.data(), header.size());
    if (size > 0) std::memcpy(bytes.data() + header.size(), data, size);
    return bytes;
}

}  // namespace

NpyFloats parseNpyFloats(std::span<const std::byte> bytes, size_t columns, const std::string& place) {
    RAIG_CHECK_OP(columns, >, 0u);
    const auto [text, begin] = splitHeader(bytes, place);
    const Header header = HeaderParser(text, place).parse();
    if (*header.descr != "<f4")
        throw inputError(place, "has dtype {:.60}; rays are '<f4': array.astype('<f4')", *header.descr);
    const auto& shape = *header.shape;
    if (shape.size() != 2 || shape[1] != columns)
        throw inputError(place, "has shape {:.60}; it should be (N, {})", describe(shape), columns);
    if (*header.fortranOrder && shape[0] != 1)
        throw inputError(place, "is in Fortran order; rows should be contiguous: numpy.ascontiguousarray(array)");

    const size_t held = bytes.size() - begin;
    const size_t rowBytes = columns * sizeof(float);
    if (held % rowBytes != 0 || held / rowBytes != shape[0])
        throw inputError(place, "holds {} bytes of data, but shape {} takes {} bytes a row: it is cut short or damaged",
                         held, describe(shape), rowBytes);
    NpyFloats result;
    result.rows = static_cast<size_t>(shape[0]);
    result.columns = columns;
    result.values.resize(result.rows * columns);
    if (held > 0) std::memcpy(result.values.data(), bytes.data() + begin, held);
    return result;
}

NpyFloats readNpyFloats(const std::filesystem::path& path, size_t columns) {
    return parseNpyFloats(readFile(path), columns, path.string());
}

std::vector<std::byte> encodeNpyHits(std::span<const NpyHit> hits) {
    const std::string fields = "[('t', '<f4'), ('u', '<f4'), ('v', '<f4'), ('primitive', '<u4'), ('instance', '<u4')]";
    return join(makeHeader(fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': ({},), }}", fields, hits.size())),
                hits.data(), hits.size_bytes());
}

void writeNpyHits(const std::filesystem::path& path, std::span<const NpyHit> hits) {
    writeFileAtomically(path, encodeNpyHits(hits));
}

std::vector<std::byte> encodeNpyFloats(std::span<const float> values, size_t columns) {
    RAIG_CHECK(columns > 0 && values.size() % columns == 0);
    return join(makeHeader(fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
                                       values.size() / columns, columns)),
                values.data(), values.size_bytes());
}

}  // namespace raig
