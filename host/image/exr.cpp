/// OpenEXR pictures, through the library of that name. The header's attributes are walked before the library sees them, so
/// that no size in it makes the library allocate more than the file warrants.
#include "base/error.hpp"
#include "image/formats.hpp"

#include <IexBaseExc.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

namespace raig::image {

namespace {

class MemoryOutput final : public Imf::OStream {
public:
    explicit MemoryOutput(Bytes& target) : Imf::OStream("memory"), bytes(target) {}
    void write(const char data[], int count) override {
        const auto size = static_cast<size_t>(count);
        if (bytes.size() < at + size) bytes.resize(at + size);
        std::memcpy(bytes.data() + at, data, size);
        at += size;
    }
    uint64_t tellp() override { return at; }
    void seekp(uint64_t position) override { at = position; }

private:
    Bytes& bytes;
    size_t at = 0;
};

class MemoryInput final : public Imf::IStream {
public:
    explicit MemoryInput(ByteSpan source) : Imf::IStream("memory"), bytes(source) {}
    bool read(char data[], int count) override {
        const auto size = static_cast<size_t>(count);
        if (count < 0 || at > bytes.size() || size > bytes.size() - at) throw Iex::InputExc("the file ends too early");
        std::memcpy(data, bytes.data() + at, size);
        at += size;
        return at < bytes.size();
    }
    uint64_t tellg() override { return at; }
    void seekg(uint64_t position) override { at = position; }

private:
    ByteSpan bytes;
    size_t at = 0;
};

/// A slice of 32-bit words, `stride` of them a pixel, whose first pixel is the data window's corner. The library wants the
/// address of pixel (0, 0), which may lie outside the array: hence the arithmetic on an integer.
Imf::Slice slice(const void* first, size_t stride, const Imath::Box2i& window, Imf::PixelType type = Imf::FLOAT) {
    const auto xStride = static_cast<int64_t>(stride * sizeof(float));
    const int64_t yStride = xStride * (int64_t{window.max.x} - window.min.x + 1);
    const int64_t base = reinterpret_cast<intptr_t>(first) - window.min.x * xStride - window.min.y * yStride;
    return Imf::Slice(type, reinterpret_cast<char*>(base), static_cast<size_t>(xStride), static_cast<size_t>(yStride));
}

}  // namespace

Bytes encodeExr(uint32_t width, uint32_t height, std::span<const vec3> pixels, std::span<const Layer> layers,
                const Notes& notes) {
    if (width > 1u << 24 || height > 1u << 24)
        throw limitError("an exr of {} x {} pixels is too large to write", width, height);
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.compression() = Imf::ZIP_COMPRESSION;
    std::string comments;
    for (const auto& [key, value] : notes) comments += fmt::format("{}{}: {}", comments.empty() ? "" : "\n", key, value);
    if (!comments.empty()) Imf::addComments(header, comments);

    Imf::FrameBuffer frame;  // the library only reads from it
    const auto insert = [&](const std::string& name, const void* first, size_t stride, Imf::PixelType type) {
        header.channels().insert(name, Imf::Channel(type));
        frame.insert(name, slice(first, stride, header.dataWindow(), type));
    };
    const char* const names[] = {"R", "G", "B"};
    for (int k = 0; k < 3 && !pixels.empty(); ++k) insert(names[k], &pixels[0].x + k, 3, Imf::FLOAT);
    for (const Layer& layer : layers)
        for (size_t k = 0; k < layer.channels.size(); ++k)
            insert(layer.name + "." + layer.channels[k], layer.words.data() + k, layer.channels.size(),
                   layer.isWhole ? Imf::UINT : Imf::FLOAT);
    Bytes bytes;
    {
        MemoryOutput stream(bytes);
        Imf::OutputFile file(stream, header, /* numThreads= */ 0);
        file.setFrameBuffer(frame);
        file.writePixels(static_cast<int>(height));
    }  // the table of row offsets is written on closing
    return bytes;
}

namespace {

uint32_t loadLittle(const std::byte* at) {
    uint32_t value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

/// A string of at most 255 bytes and its terminating zero, from `at` on, which moves behind it.
std::optional<std::string_view> takeName(ByteSpan bytes, size_t& at) {
    const auto* begin = reinterpret_cast<const char*>(bytes.data()) + at;
    const void* end = std::memchr(begin, 0, std::min<size_t>(bytes.size() - at, 256));
    if (!end) return std::nullopt;
    const std::string_view name(begin, static_cast<size_t>(static_cast<const char*>(end) - begin));
    at += name.size() + 1;
    return name;
}

/// Walks the header and checks what the library would allocate by.
void checkHeader(ByteSpan bytes, const std::string& place) {
    const auto damaged = [&] { return inputError(place, "is cut short or damaged: its OpenEXR header does not end"); };
    if (bytes.size() < 8) throw damaged();
    const uint32_t version = loadLittle(bytes.data() + 4);
    constexpr uint32_t deepFlag = 0x800, partsFlag = 0x1000;
    if (version & (deepFlag | partsFlag)) throw inputError(place, "has deep pixels or several parts, which are not read");

    bool sized = false;
    for (size_t at = 8;;) {
        const auto name = takeName(bytes, at);
        if (!name) throw damaged();
        if (name->empty()) break;
        const auto type = takeName(bytes, at);
        if (!type || bytes.size() - at < 4) throw damaged();
        const uint32_t size = loadLittle(bytes.data() + at);
        at += 4;
        if (size > bytes.size() - at) throw damaged();
        if (*name == "dataWindow" && size == 16) {
            int32_t box[4];
            std::memcpy(box, bytes.data() + at, sizeof box);
            const auto extent = [](int32_t lo, int32_t hi) {
                return hi < lo ? 0 : static_cast<uint64_t>(int64_t{hi} - lo + 1);
            };
            // DWA keeps one value of 8 x 8, and deflates that.
            checkSize(extent(box[0], box[2]), extent(box[1], box[3]), bytes.size(), 64 * 1032, place);
            sized = true;
        }
        if (*name == "tiles" && size >= 8) {
            const uint64_t x = loadLittle(bytes.data() + at), y = loadLittle(bytes.data() + at + 4);
            if (x > 65536 || y > 65536 || x * y > 1u << 24)
                throw limitError("{}: has tiles of {} x {} pixels, too large to read", place, x, y);
        }
        if (*name == "channels" && size > 16384) throw limitError("{}: has more channels than can be read", place);
        at += size;
    }
    if (!sized) throw inputError(place, "is damaged: its OpenEXR header names no data window");
}

/// The channels to read as red, green and blue; grey is its own three.
std::array<const char*, 3> pickChannels(const Imf::ChannelList& channels, const std::string& place) {
    std::array<const char*, 3> names = {"R", "G", "B"};
    const bool colour = channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B");
    const bool chroma = channels.findChannel("RY") || channels.findChannel("BY");
    if (!colour) names.fill("Y");
    if (!colour && (chroma || !channels.findChannel("Y"))) {
        std::string found;
        for (auto it = channels.begin(); it != channels.end(); ++it) found += fmt::format(" {}", it.name());
        throw inputError(place, "has no channels R, G, B or Y to read, but{}", found.empty() ? " none" : found);
    }
    for (const char* name : names) {
        const Imf::Channel& channel = channels[name];
        if (channel.xSampling != 1 || channel.ySampling != 1)
            throw inputError(place, "has subsampled channels, which are not read");
    }
    return names;
}

Image read(ByteSpan bytes, const std::string& place) {
    MemoryInput stream(bytes);
    Imf::InputFile file(stream, /* numThreads= */ 0);
    const Imath::Box2i window = file.header().dataWindow();
    const auto names = pickChannels(file.header().channels(), place);
    Image image(static_cast<uint32_t>(window.max.x - window.min.x + 1),
                static_cast<uint32_t>(window.max.y - window.min.y + 1));
    Imf::FrameBuffer frame;
    const bool grey = names[0] == names[1];
    for (int k = 0; k < (grey ? 1 : 3); ++k) frame.insert(names[k], slice(&image.pixels[0].x + k, 3, window));
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    if (grey)
        for (vec3& c : image.pixels) c = vec3(c.x);
    return image;
}

}  // namespace

Image decodeExr(ByteSpan bytes, const std::string& place) {
    checkHeader(bytes, place);
    try {
        return read(bytes, place);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        std::string reason = error.what();
        std::replace(reason.begin(), reason.end(), '\n', ' ');
        throw inputError(place, "cannot be read as OpenEXR: {}", reason);
    }
}

}  // namespace raig::image
