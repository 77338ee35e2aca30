/// A triangle whose material has maps, and pictures for these.
#pragma once

#include "scene/import.hpp"
#include "scene/validate.hpp"
#include "support/mesh_files.hpp"

#include <array>

namespace raig::test {

/// Red, green, blue, alpha.
using Texel = std::array<uint8_t, 4>;

/// A TGA file, row by row from the top.
inline std::string tga(uint32_t width, uint32_t height, const std::vector<Texel>& texels) {
    const auto low = [](uint32_t side) { return static_cast<char>(side & 255); };
    const auto high = [](uint32_t side) { return static_cast<char>(side >> 8); };
    std::string bytes(12, '\0');
    bytes[2] = 2;
    bytes += {low(width), high(width), low(height), high(height), 32, 0x28};
    for (const Texel& t : texels)
        for (const uint8_t byte : {t[2], t[1], t[0], t[3]}) bytes += static_cast<char>(byte);
    return bytes;
}

inline const Texel red{255, 0, 0, 255}, grey{128, 128, 128, 255}, black{0, 0, 0, 255}, white{255, 255, 255, 255};

struct File {
    std::string name, content;
};

/// A triangle of material m, as these statements make it, beside these files.
inline Scene load(const std::string& statements, const std::vector<File>& files) {
    const Folder folder;
    folder.write("m.mtl", "newmtl m\n" + statements);
    for (const File& file : files) folder.write(file.name, file.content);
    const Scene scene = importObj(
        folder.write("s.obj", "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"));
    EXPECT_EQ(findFault(scene), std::nullopt);
    return scene;
}

}  // namespace raig::test
