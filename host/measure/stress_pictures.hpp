/// The hard cases that are judged by pictures, run: pixels that are not what they must be; and structures whose links were
/// led astray.
#pragma once

#include "measure/hard_pictures.hpp"
#include "measure/stress.hpp"

namespace raig {

/// What is put to the test.
struct PictureSubject {
    std::string structure;
    std::string options;  ///< as on the command line; empty: none
    /// The pictures by all of the scene's options. May throw what renderPicture and tracers do.
    std::function<std::vector<Picture>(const hard::PictureScene&)> render;
};

/// A structure on a device, or on the CPU where there is none. The device must outlive the subject.
PictureSubject pictureSubjectOf(const Variant& variant, Device* device);

struct PictureSettings {
    std::vector<hard::PictureCase> cases;
    hard::Draw draw;
    std::string device;                    ///< its name, for the results
    size_t deviceNumber = 0;               ///< among all devices of the run, for the results
    bool isDevice = false;                 ///< not the CPU: scenes that pretend a device's limits are run, too
    bool draws = false;                    ///< a device opened with DeviceOptions::graphics: so are item buffers
    std::vector<PictureSubject> subjects;  ///< with the bits of the first, others are compared
};

/// Runs all cases with all subjects; as stress(), where rays are pixels. wrong: pixels that are not what is known of them;
/// differs: with other bits than the first subject's, or than the first of pictures that must be alike.
StressReport stressPictures(const PictureSettings& settings,
                            const std::function<void(const std::string&, double)>& progress);

/// Traces rays through a structure in memory whose links were made to lead around. May throw what a Tracer does.
using TraceCorrupt = std::function<void(const Structure& structure, std::span<const Ray> rays, std::span<Hit> hits)>;
TraceCorrupt corruptTraceOf(Device* device);

/// Case 62: each variant, its links led around, must be told to be corrupt, and soon: else its rays are hung, or wrong where
/// there was an answer. Variants without links have no result.
StressReport stressCorruption(std::span<const Variant> variants, const TraceCorrupt& trace, const hard::Draw& draw,
                              const std::string& device, size_t deviceNumber);

}  // namespace raig
