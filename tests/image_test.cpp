// Pictures written and read back: what each format keeps, and that no file, however damaged, is taken for a whole one,
// crashes the readers or makes them allocate what it has no bytes for.
#include "image/image.hpp"
#include "base/error.hpp"
#include "base/files.hpp"
#include "support/images.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <random>

#include <unistd.h>

namespace raig {
namespace {

using test::noise;

using Bytes = std::vector<std::byte>;

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Bytes bytesOf(std::string_view text) {
    Bytes bytes(text.size());
    if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

std::string textOf(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool sameBits(const Image& a, const Image& b) {
    return a.width == b.width && a.height == b.height && a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec3)) == 0;
}

Image roundTrip(const Image& image, PictureFormat format, const Notes& notes = {}) {
    return decodePicture(encodePicture(image, format, notes), "picture");
}

/// The error that decoding throws, or nothing if it throws none. Anything else than an Error fails the test.
std::optional<Error> decodingError(const Bytes& bytes) {
    try {
        const Image image = decodePicture(bytes, "picture");
        EXPECT_EQ(image.pixels.size(), size_t{image.width} * image.height);
        return std::nullopt;
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        EXPECT_TRUE(std::string(error.what()).starts_with("picture: ")) << error.what();
        return error;
    }
}

constexpr PictureFormat allFormats[] = {PictureFormat::png, PictureFormat::hdr, PictureFormat::exr, PictureFormat::pfm};

const std::pair<uint32_t, uint32_t> oddSizes[] = {{1, 1}, {1, 7}, {7, 1}, {8, 3}, {9, 9}, {127, 2}, {130, 5}, {40000, 1}};

TEST(Picture, FloatFormatsKeepEveryBit) {
    for (const auto format : {PictureFormat::exr, PictureFormat::pfm})
        for (const auto& [width, height] : oddSizes) {
            Image image = noise(width, height, 1, 1e6f);
            image.pixels.front() = {nan, inf, -inf};
            image.pixels.back() = {-0.0f, 1e-42f, std::numeric_limits<float>::max()};
            EXPECT_TRUE(sameBits(roundTrip(image, format), image)) << width << " x " << height;
        }
}

TEST(Picture, PngKeepsEverySrgbByteAndItsPlace) {
    const auto decoded = [](int byte) {
        const double v = byte / 255.0;
        return static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    };
    Image image(256, 2);
    for (int i = 0; i < 256; ++i) {
        image.at(i, 0) = {decoded(i), decoded(255 - i), decoded((i * 7) % 256)};
        image.at(i, 1) = {decoded((i * 31) % 256), 0.0f, 1.0f};
    }
    EXPECT_TRUE(sameBits(roundTrip(image, PictureFormat::png), image));
}

TEST(Picture, PngRoundsToTheNearestByte) {
    const auto encode = [](double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055; };
    const Image image = noise(300, 20, 2);
    const Image back = roundTrip(image, PictureFormat::png);
    for (size_t i = 0; i < image.pixels.size(); ++i)
        for (int k = 0; k < 3; ++k)
            ASSERT_LE(std::abs(encode(image.pixels[i][k]) - encode(back.pixels[i][k])) * 255, 0.5 + 1e-4);
}

TEST(Picture, PngClampsAndShowsNanAsMagenta) {
    Image image(5, 1);
    image.pixels = {{-1, 2, 0}, {inf, -inf, 0.0f}, {nan, 0, 0}, {0, nan, 5}, {1e30f, -1e30f, -0.0f}};
    const Image back = roundTrip(image, PictureFormat::png);
    EXPECT_EQ(back.pixels[0], vec3(0, 1, 0));
    EXPECT_EQ(back.pixels[1], vec3(1, 0, 0));
    EXPECT_EQ(back.pixels[2], vec3(1, 0, 1));
    EXPECT_EQ(back.pixels[3], vec3(1, 0, 1));
    EXPECT_EQ(back.pixels[4], vec3(1, 0, 0));
    EXPECT_EQ(countNonFinite(image), 3u);
}

TEST(Picture, HdrIsRightToHalfAStepAndWritesWhatItReadUnchanged) {
    for (const float scale : {1e-20f, 1.0f, 1e20f})
        for (const auto& [width, height] : oddSizes) {
            const Image image = noise(width, height, 3, scale);
            const Image back = roundTrip(image, PictureFormat::hdr);
            for (size_t i = 0; i < image.pixels.size(); ++i) {
                const float largest = std::max({image.pixels[i].x, image.pixels[i].y, image.pixels[i].z});
                // The largest mantissa is 128..255 steps, and at least 255.5 / 2 where it was rounded up to the next
                // exponent.
                for (int k = 0; k < 3; ++k) ASSERT_LE(std::abs(back.pixels[i][k] - image.pixels[i][k]), largest / 255.5f);
            }
            EXPECT_TRUE(sameBits(roundTrip(back, PictureFormat::hdr), back)) << width << " x " << height;
        }
}

TEST(Picture, HdrHoldsTheNearestOfWhatItCannotHold) {
    Image image(4, 1);
    image.pixels = {{-1, 1, 0}, {inf, 0, 0}, {nan, 0, 0}, {255.75f, 128.5f, 0}};
    const Image back = roundTrip(image, PictureFormat::hdr);
    EXPECT_EQ(back.pixels[0], vec3(0, 1, 0));
    EXPECT_EQ(back.pixels[1], vec3(std::ldexp(255.0f, 119), 0, 0));
    EXPECT_EQ(back.pixels[2], vec3(1, 0, 1));
    EXPECT_EQ(back.pixels[3], vec3(256, 128, 0));  // 255.75 rounds up into the next exponent, whose step is 2
}

TEST(Picture, SamePictureGivesSameBytes) {
    const Image image = noise(97, 61, 4);
    for (const auto format : allFormats) EXPECT_EQ(encodePicture(image, format), encodePicture(image, format));
}

TEST(Picture, NotesAreInTheFileAndChangeNoPixel) {
    const Image image = noise(33, 17, 5);
    const Notes notes = {
        {"Software", "raig"}, {"raig", "NIVELL_MAX 8, MIN_CONTRIB 1/512\nsecond line"}, {"Title", "lli\xc3\xa7\xc3\xb3"}};
    for (const auto format : {PictureFormat::png, PictureFormat::hdr, PictureFormat::exr}) {
        const Bytes bytes = encodePicture(image, format, notes);
        EXPECT_NE(textOf(bytes).find("NIVELL_MAX 8, MIN_CONTRIB 1/512"), std::string::npos);
        EXPECT_NE(textOf(bytes).find("lli\xc3\xa7\xc3\xb3"), std::string::npos);
        EXPECT_TRUE(sameBits(decodePicture(bytes, "picture"), roundTrip(image, format)));
    }
    EXPECT_EQ(encodePicture(image, PictureFormat::pfm, notes), encodePicture(image, PictureFormat::pfm));
}

TEST(Picture, EndingNamesTheFormat) {
    EXPECT_EQ(pictureFormat("a/b.PNG"), PictureFormat::png);
    EXPECT_EQ(pictureFormat("b.hdr"), PictureFormat::hdr);
    EXPECT_EQ(pictureFormat("b.c.Exr"), PictureFormat::exr);
    EXPECT_EQ(pictureFormat("b.pfm"), PictureFormat::pfm);
    for (const char* wrong : {"a.jpg", "png", "a", "", "a.png.txt"}) {
        try {
            (void)pictureFormat(wrong);
            ADD_FAILURE() << wrong;
        } catch (const Error& error) {
            EXPECT_EQ(error.exitCode, ExitCode::usage);
            for (const char* name : {".png", ".hdr", ".exr", ".pfm"})
                EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
        }
    }
}

TEST(Picture, WritingAndReadingAFileGoesByEnding) {
    const auto folder = std::filesystem::temp_directory_path() / fmt::format("raig_image_test_{}", ::getpid());
    std::filesystem::create_directory(folder);
    Image image = noise(12, 9, 6);
    image.at(3, 3).y = nan;
    for (const char* name : {"a.png", "a.hdr", "a.exr", "a.pfm"}) {
        EXPECT_EQ(writePicture(folder / name, image), 1u);
        EXPECT_TRUE(sameBits(readPicture(folder / name), roundTrip(image, pictureFormat(name)))) << name;
    }
    EXPECT_THROW(writePicture(folder / "absent" / "a.png", image), Error);
    EXPECT_THROW(writePicture(folder / "a.gif", image), Error);
    EXPECT_THROW((void)readPicture(folder / "absent.png"), Error);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 4);  // nothing half-written is left
    std::filesystem::remove_all(folder);
}

// Cut at any length, a file is refused: none of the readers fills the rest with black or grey.
TEST(DamagedPicture, CutShortAnywhereIsRefused) {
    for (const auto format : allFormats)
        for (const auto& [width, height] : {std::pair{5u, 4u}, std::pair{40u, 7u}}) {
            const Bytes whole = encodePicture(noise(width, height, 7), format, {{"raig", "a note"}});
            ASSERT_FALSE(decodingError(whole));
            for (size_t length = 0; length < whole.size(); ++length) {
                const auto error = decodingError(Bytes(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(length)));
                ASSERT_TRUE(error) << "format " << static_cast<int>(format) << ", " << length << " of " << whole.size();
                EXPECT_EQ(error->exitCode, ExitCode::badInput);
            }
        }
}

TEST(DamagedPicture, FlippedBytesNeverDoWorseThanAnError) {
    std::mt19937 random(8);
    for (const auto format : allFormats) {
        const Bytes whole = encodePicture(noise(40, 17, 9), format, {{"raig", "a note"}});
        for (int round = 0; round < 1500; ++round) {
            Bytes bytes = whole;
            const size_t head = round % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 400);
            for (unsigned flips = 1 + random() % 3; flips > 0; --flips)
                bytes[random() % head] = static_cast<std::byte>(random());
            (void)decodingError(bytes);
        }
    }
}

TEST(DamagedPicture, AnyFlippedByteOfAPngIsNoticed) {
    const Bytes whole = encodePicture(noise(9, 9, 10), PictureFormat::png);
    for (size_t i = 0; i < whole.size(); ++i) {
        Bytes bytes = whole;
        bytes[i] ^= std::byte{0x10};
        EXPECT_TRUE(decodingError(bytes)) << "byte " << i;
    }
}

// A header that promises 65536 x 65536 pixels (and more) in a file of some hundred bytes: an error at once, no 50 GiB.
TEST(DamagedPicture, HugePromisesAreRefusedAtOnce) {
    Bytes exr = encodePicture(Image(1, 1), PictureFormat::exr);
    const size_t window = textOf(exr).find("dataWindow") + std::strlen("dataWindow") + 1 + std::strlen("box2i") + 1 + 4;
    for (const int32_t top : {65535, 16383, 2147483647}) {
        const int32_t box[4] = {0, 0, top, top};
        std::memcpy(exr.data() + window, box, sizeof box);
        EXPECT_TRUE(decodingError(exr)) << top;
    }
    for (const char* size :
         {"65536 65536", "16384 16384", "4294967295 4294967295", "99999999999 1", "0 5", "5 0", "-3 4", "3"})
        EXPECT_TRUE(decodingError(bytesOf(fmt::format("PF\n{}\n-1.0\n0123456789ab", size)))) << size;
    for (const char* size : {"-Y 65536 +X 65536", "-Y 16384 +X 16384", "-Y 0 +X 4", "-Y 4", "+Y 4 +X 4", "-Y 4 +X 4 5"})
        EXPECT_TRUE(decodingError(bytesOf(fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{}\n0123456789ab", size))))
            << size;
}

TEST(DamagedPicture, HugePngsAreRefusedThoughTheirChecksumsAreRight) {
    // A 65535 x 65535 header over the pixels of one.
    const std::string head("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\xff\xff\0\0\xff\xff\x08\x02\0\0\0", 29);
    const std::string crcs = [&] {
        uint32_t crc = 0xffffffffu;
        for (size_t i = 12; i < head.size(); ++i) {
            crc ^= static_cast<unsigned char>(head[i]);
            for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0xedb88320u : 0u);
        }
        crc = ~crc;
        return std::string{char(crc >> 24), char(crc >> 16), char(crc >> 8), char(crc)};
    }();
    const std::string tail = textOf(encodePicture(Image(1, 1), PictureFormat::png)).substr(33);
    const auto error = decodingError(bytesOf(head + crcs + tail));
    ASSERT_TRUE(error);
    EXPECT_EQ(error->exitCode, ExitCode::limit) << error->what();
}

TEST(DamagedPicture, WhatIsNoPictureIsRefused) {
    for (const char* text :
         {"", "P", "PF", "#?", "GIF89a", "BM", "hello", "\xff\xd8\xff", "PF 1 1 0 123456789012", "PF 1 1 nan 123456789012"})
        EXPECT_TRUE(decodingError(bytesOf(text))) << text;
}

TEST(Pfm, ReadsBothByteOrdersAndGreyFromTheBottomUp) {
    const std::string big("Pf\n1 2\n1.0\n\x3f\x80\x00\x00\x40\x00\x00\x00", 19);
    const Image image = decodePicture(bytesOf(big), "picture");
    EXPECT_EQ(image.at(0, 1), vec3(1.0f));
    EXPECT_EQ(image.at(0, 0), vec3(2.0f));
    const std::string little("PF 1 1 -0.5\n\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x40\x40", 24);
    EXPECT_EQ(decodePicture(bytesOf(little), "picture").at(0, 0), vec3(1, 2, 3));
}

TEST(Hdr, RunsAreReadAndBadOnesRefused) {
    const std::string head = "#?RGBE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 1 +X 9\n";
    const std::string start("\x02\x02\x00\x09", 4);
    const auto run = [](char value) { return std::string{char(128 + 9), value}; };
    const Image image = decodePicture(bytesOf(head + start + run(char(128)) + run(64) + run(0) + run(char(129))), "picture");
    for (const vec3& c : image.pixels) EXPECT_EQ(c, vec3(1.0f, 0.5f, 0.0f));
    for (const std::string& bad : {std::string{char(128 + 10), 1}, std::string{char(0), 1}, std::string{char(128), 1}})
        EXPECT_TRUE(decodingError(bytesOf(head + start + bad + std::string(64, '\1'))));
    EXPECT_TRUE(decodingError(bytesOf(head + std::string("\x02\x02\x00\x08", 4) + std::string(64, '\1'))));  // another width
}

// A grey 8 x 8 baseline JPEG, written by hand: one block, its DC coefficient 0, so mid-grey (128).
TEST(Jpeg, GreyIsDecodedAndCutShortIsRefused) {
    std::string jpeg("\xff\xd8\xff\xdb\x00\x43\x00", 7);
    jpeg += std::string(64, '\1');                                                    // quantisation: all 1
    jpeg += std::string("\xff\xc0\x00\x0b\x08\x00\x08\x00\x08\x01\x01\x11\x00", 13);  // 8 x 8, one component
    for (const char table : {'\x00', '\x10'})                                         // one code of one bit: 0 means 0
        jpeg += std::string("\xff\xc4\x00\x14", 4) + table + '\1' + std::string(15, '\0') + '\0';
    jpeg += std::string("\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00", 10);
    jpeg += std::string("\x3f\xff\xd9", 3);  // DC 0, end of block, ones to fill
    const Image image = decodePicture(bytesOf(jpeg), "picture");
    ASSERT_EQ(image.pixels.size(), 64u);
    for (const vec3& c : image.pixels) EXPECT_NEAR(c.x, 0.2158605f, 1e-6f);
    for (size_t length = 0; length + 3 < jpeg.size(); ++length)
        EXPECT_TRUE(decodingError(bytesOf(jpeg.substr(0, length)))) << length;
}

}  // namespace
}  // namespace raig
