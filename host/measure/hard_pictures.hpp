/// The hard cases that pictures show: scenes of which each pixel is known, or bounded, by reason.
#pragma once

#include "measure/hard_cases.hpp"
#include "rays/frame.hpp"

#include <functional>
#include <string>
#include <vector>

namespace raig::hard {

/// A scene, and what is known of its pictures.
struct PictureScene {
    std::string name;
    raig::Scene scene = {};
    std::vector<FrameOptions> options = {};  ///< of each picture
    /// What is wrong with a pixel of a picture; empty: nothing. Numbers that are none are wrong in any case.
    std::function<std::string(const Picture& picture, const FrameOptions& options, size_t pixel)> fault = {};
    bool sameBits = false;  ///< all pictures must have the bits of the first
    /// Pretends that a device binds arrays of no more elements than these; 0: as it is. For devices only. Then the scene may
    /// be refused, too: the limit is told, and there is no picture.
    uint64_t largestBinding = 0;
    bool isRefused = false;       ///< it must be
    bool isDrawn = false;         ///< pictures after the first are by item buffers: for devices that draw
    bool keepsInstances = false;  ///< whatever stands in several places is stored once
};

struct PictureCase {
    uint32_t number;
    const char* what;
    std::vector<PictureScene> (*make)(const Draw&);
};

std::vector<PictureCase> recursionCases();  ///< 52 and 53: mirrors, and what divides light in two
std::vector<PictureCase> glassCases();      ///< 54 to 56
/// Of cases 54 and 55: media within media, and eyes within them.
std::vector<PictureScene> mediaInMedia();
std::vector<PictureScene> eyesInMedia();
std::vector<PictureCase> itemCases();       ///< 57: item buffers
std::vector<PictureCase> frameCases();      ///< 58 to 61: sizes, limits, tiles, numbers that are none

/// All of them, by number.
std::vector<PictureCase> pictureCases();

/// How far rounding may move what is 1 in all, after `depth` reflections: some roundings each.
double roundingOf(uint32_t depth);

/// What of a pixel is not explained: in a scene where all light has radiance 1 and none is lost, that and the discarded
/// weight make 1.
std::string furnaceFault(const Picture& picture, const FrameOptions& options, size_t pixel);

}  // namespace raig::hard
