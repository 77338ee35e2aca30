/// The header of a PLY file [Turk 1994, "The PLY Polygon File Format"]: which elements follow, and how each is laid out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace raig::ply {

enum class Encoding { ascii, binaryLittleEndian, binaryBigEndian };
enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline bool isInteger(Type type) {
    return type < Type::float32;
}
/// In bytes, in binary files.
size_t sizeOf(Type type);

struct Property {
    std::string name;
    Type type = Type::float32;
    bool isList = false;
    Type countType = Type::uint8;  ///< of a list
};

struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    Encoding encoding = Encoding::ascii;
    std::vector<Element> elements;
    size_t bodyOffset = 0;  ///< where the data begins
    size_t bodyLine = 0;    ///< the line on which it begins
};

/// Reads the header at the start of `content`. Throws inputError ("place:line") if it is malformed. Counts are not yet
/// checked against what follows.
Header readHeader(std::string_view content, const std::string& place);

/// The fewest bytes that one entry of `element` can take: what announces more entries than fit is refused by this.
size_t leastSize(const Element& element, Encoding encoding);

}  // namespace raig::ply
