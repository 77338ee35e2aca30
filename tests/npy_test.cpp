// NumPy arrays: rays read as numpy.save writes them and as nothing else does, hits written so that numpy.load takes them.
#include "rays/npy.hpp"
#include "base/error.hpp"
#include "base/files.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <random>

#include <unistd.h>

namespace raig {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytesOf(std::string_view text) {
    Bytes bytes(text.size());
    if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

std::string textOf(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A file of that version with that dictionary, padded as numpy does, and `floats` floats counting from 0.
Bytes file(const std::string& dictionary, size_t floats, int major = 1) {
    std::string text = std::string("\x93NUMPY") + static_cast<char>(major) + '\0';
    const size_t lengthBytes = major == 1 ? 2 : 4, before = 8 + lengthBytes;
    const size_t length = (before + dictionary.size() + 1 + 63) / 64 * 64 - before;
    for (size_t i = 0; i < lengthBytes; ++i) text += static_cast<char>(length >> (8 * i));
    text += dictionary + std::string(length - dictionary.size() - 1, ' ') + '\n';
    for (size_t i = 0; i < floats; ++i) {
        const auto value = static_cast<float>(i);
        text.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    return bytesOf(text);
}

std::string dictionary(const std::string& descr, const std::string& order, const std::string& shape) {
    return "{'descr': " + descr + ", 'fortran_order': " + order + ", 'shape': " + shape + ", }";
}

std::optional<Error> parsingError(const Bytes& bytes) {
    try {
        const NpyFloats array = parseNpyFloats(bytes, 8, "rays.npy");
        EXPECT_EQ(array.values.size(), array.rows * 8);
        EXPECT_LE(array.values.size() * sizeof(float), bytes.size());
        return std::nullopt;
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::badInput);
        EXPECT_TRUE(std::string(error.what()).starts_with("rays.npy: ")) << error.what();
        return error;
    }
}

TEST(NpyFloats, AreReadAsNumpySavesThemInEveryVersion) {
    for (const int major : {1, 2, 3}) {
        const NpyFloats array = parseNpyFloats(file(dictionary("'<f4'", "False", "(3, 8)"), 24, major), 8, "rays.npy");
        EXPECT_EQ(array.rows, 3u);
        EXPECT_EQ(array.columns, 8u);
        ASSERT_EQ(array.values.size(), 24u);
        for (size_t i = 0; i < 24; ++i) EXPECT_EQ(array.values[i], static_cast<float>(i));
    }
}

TEST(NpyFloats, KeepEveryBit) {
    std::vector<float> values(16, std::numeric_limits<float>::quiet_NaN());
    values[1] = -0.0f;
    values[2] = std::numeric_limits<float>::infinity();
    values[3] = 1e-45f;
    const NpyFloats array = parseNpyFloats(encodeNpyFloats(values, 8), 8, "rays.npy");
    EXPECT_EQ(array.rows, 2u);
    EXPECT_EQ(std::memcmp(array.values.data(), values.data(), 64), 0);
}

TEST(NpyFloats, MayBeNone) {
    EXPECT_EQ(parseNpyFloats(file(dictionary("'<f4'", "False", "(0, 8)"), 0), 8, "rays.npy").rows, 0u);
}

TEST(NpyFloats, HeaderMayBeSpacedQuotedAndOrderedOtherwise) {
    for (const char* text : {"{\"shape\": (1, 8), \"fortran_order\": False, \"descr\": \"<f4\"}",
                             "{'fortran_order':False,'descr':'<f4','shape':(1,8,)}",
                             "  {  'descr' : '<f4' ,\n 'fortran_order' : True , 'shape' : ( 1 , 8 ) , }  "})
        EXPECT_FALSE(parsingError(file(text, 8))) << text;
}

TEST(NpyFloats, OfAnotherKindAreRefusedByName) {
    const auto refused = [](const Bytes& bytes, const char* word) {
        const auto error = parsingError(bytes);
        ASSERT_TRUE(error) << word;
        EXPECT_NE(std::string(error->what()).find(word), std::string::npos) << error->what();
    };
    refused(file(dictionary("'<f8'", "False", "(3, 8)"), 48), "dtype <f8");
    refused(file(dictionary("'>f4'", "False", "(3, 8)"), 24), "dtype >f4");
    refused(file(dictionary("[('a', '<f4'), ('b', '<f4', (2,))]", "False", "(3,)"), 24), "dtype [('a'");
    refused(file(dictionary("'<f4'", "True", "(3, 8)"), 24), "Fortran order");
    refused(file(dictionary("'<f4'", "False", "(24,)"), 24), "shape (24,)");
    refused(file(dictionary("'<f4'", "False", "(4, 6)"), 24), "shape (4, 6)");
    refused(file(dictionary("'<f4'", "False", "()"), 1), "shape ()");
    refused(file(dictionary("'<f4'", "False", "(3, 8)"), 23), "cut short");
    refused(file(dictionary("'<f4'", "False", "(3, 8)"), 32), "holds 128 bytes");
    refused(file(dictionary("'<f4'", "False", "(3, 8)"), 24, 4), "version 4.0");
    refused(bytesOf("o,d\n1,2\n"), "no NumPy .npy file");
    refused(bytesOf("PK\x03\x04 a .npz file"), "no NumPy .npy file");
    refused({}, "no NumPy .npy file");
}

TEST(NpyFloats, HeaderThatIsNoDictionaryIsRefused) {
    for (const char* text :
         {"", "{", "}", "{}", "{'descr': '<f4'}", "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 8)",
          "{'descr': '<f4', 'fortran_order': false, 'shape': (1, 8)}",
          "{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (1, 8)}",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 8), 'more': 1}",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 8)} x",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 8)}",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (1.0, 8)}",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (1 8)}",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (8)}",
          "{'descr': '<f4' 'fortran_order': False, 'shape': (1, 8)}",
          "{'descr': '<f4, 'fortran_order': False, 'shape': (1, 8)}",
          "{'descr': [[[, 'fortran_order': False, 'shape': (1, 8)}",
          "{'descr': <f4, 'fortran_order': False, 'shape': (1, 8)}",
          "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 8, }"})
        EXPECT_TRUE(parsingError(file(text, 8))) << text;
}

// A shape that overflows when multiplied out, or promises more than memory holds, costs nothing.
TEST(NpyFloats, HugeShapesAreRefusedAtOnce) {
    for (const char* rows :
         {"1000000000000", "2305843009213693952", "576460752303423489", "18446744073709551615", "99999999999999999999999"})
        EXPECT_TRUE(parsingError(file(dictionary("'<f4'", "False", std::string("(") + rows + ", 8)"), 8))) << rows;
    Bytes bytes = file(dictionary("'<f4'", "False", "(1, 8)"), 8, 2);
    for (size_t i = 8; i < 12; ++i) bytes[i] = std::byte{0xff};  // a header of 4 GiB
    EXPECT_TRUE(parsingError(bytes));
}

TEST(NpyFloats, CutShortAnywhereAreRefused) {
    for (const int major : {1, 2}) {
        const Bytes whole = file(dictionary("'<f4'", "False", "(2, 8)"), 16, major);
        ASSERT_FALSE(parsingError(whole));
        for (size_t length = 0; length < whole.size(); ++length)
            EXPECT_TRUE(parsingError(Bytes(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(length)))) << length;
    }
}

// Any value of any byte of the header, and random pairs of them: an array or an error.
TEST(NpyFloats, FlippedBytesNeverDoWorseThanAnError) {
    const Bytes whole = file(dictionary("'<f4'", "False", "(2, 8)"), 16);
    for (size_t i = 0; i < whole.size() - 64; ++i)
        for (int value = 0; value < 256; ++value) {
            Bytes bytes = whole;
            bytes[i] = static_cast<std::byte>(value);
            (void)parsingError(bytes);
        }
    std::mt19937 random(1);
    for (int round = 0; round < 20000; ++round) {
        Bytes bytes = whole;
        for (unsigned flips = 2 + random() % 4; flips > 0; --flips) bytes[random() % 90] = static_cast<std::byte>(random());
        (void)parsingError(bytes);
    }
}

// Version 1.0: magic, 1, 0, the header's length in two bytes; the header is one line, padded so that the data begins at a
// multiple of 64.
TEST(NpyHits, AreWrittenAsTheFormatSays) {
    const std::vector<NpyHit> hits = {{1.5f, 0.25f, 0.5f, 7, 2}, {0.0f, 0.0f, 0.0f, 0xffffffffu, 0xffffffffu}};
    const Bytes bytes = encodeNpyHits(hits);
    const std::string text = textOf(bytes);
    ASSERT_GE(text.size(), 10u);
    EXPECT_EQ(text.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    const size_t length = static_cast<unsigned char>(text[8]) + 256u * static_cast<unsigned char>(text[9]);
    EXPECT_EQ((10 + length) % 64, 0u);
    ASSERT_EQ(text.size(), 10 + length + 40);
    const std::string header = text.substr(10, length);
    EXPECT_EQ(header.back(), '\n');
    const std::string literal =
        "{'descr': [('t', '<f4'), ('u', '<f4'), ('v', '<f4'), ('primitive', '<u4'), ('instance', '<u4')], "
        "'fortran_order': False, 'shape': (2,), }";
    EXPECT_EQ(header.substr(0, literal.size()), literal);
    EXPECT_EQ(header.find_first_not_of(' ', literal.size()), length - 1);
    EXPECT_EQ(text.substr(10 + length, 20), std::string("\0\0\xc0\x3f\0\0\x80\x3e\0\0\0\x3f\x07\0\0\0\x02\0\0\0", 20));
    EXPECT_EQ(text.substr(10 + length + 32), std::string(8, '\xff'));
}

TEST(NpyHits, MayBeNone) {
    const std::string text = textOf(encodeNpyHits({}));
    EXPECT_EQ(text.size() % 64, 0u);
    EXPECT_NE(text.find("'shape': (0,), }"), std::string::npos);
}

// As root, renaming a new file over /dev/null would make a file of it, for everyone.
TEST(NpyFiles, ReplaceWhatALinkPointsToAndNoDevice) {
    const auto folder = std::filesystem::temp_directory_path() / fmt::format("raig_npy_link_test_{}", ::getpid());
    std::filesystem::create_directory(folder);
    const std::vector<NpyHit> hits(3, NpyHit{1, 2, 3, 4, 5});
    writeNpyHits(folder / "hits.npy", {});
    std::filesystem::create_symlink("hits.npy", folder / "link.npy");
    writeNpyHits(folder / "link.npy", hits);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.npy"));
    EXPECT_EQ(readFile(folder / "hits.npy"), encodeNpyHits(hits));

    std::filesystem::create_symlink("/dev/full", folder / "full.npy");  // the link, so that a failure harms nobody
    EXPECT_THROW(writeNpyHits(folder / "full.npy", hits), Error);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "full.npy"));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 3);  // nothing half-written is left
    std::filesystem::remove_all(folder);
}

TEST(NpyFiles, AreReadAndWrittenWhole) {
    const auto folder = std::filesystem::temp_directory_path() / fmt::format("raig_npy_test_{}", ::getpid());
    std::filesystem::create_directory(folder);
    const std::vector<float> values(80, 2.5f);
    writeFileAtomically(folder / "rays.npy", encodeNpyFloats(values, 8));
    EXPECT_EQ(readNpyFloats(folder / "rays.npy", 8).values, values);
    EXPECT_THROW((void)readNpyFloats(folder / "absent.npy", 8), Error);
    EXPECT_THROW((void)readNpyFloats(folder, 8), Error);
    const std::vector<NpyHit> hits(3, NpyHit{1, 2, 3, 4, 5});
    writeNpyHits(folder / "hits.npy", hits);
    EXPECT_EQ(readFile(folder / "hits.npy"), encodeNpyHits(hits));
    EXPECT_THROW(writeNpyHits(folder / "absent" / "hits.npy", hits), Error);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace raig
