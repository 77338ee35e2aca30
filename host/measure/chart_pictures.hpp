/// A scene's picture by the device, by the reference, and what is between them.
#pragma once

#include "device/device.hpp"
#include "measure/chart_document.hpp"
#include "measure/chart_scene.hpp"

namespace raig {

/// side x side pixels of four samples, with the same random numbers on both sides. `device`: none, the CPU path.
ChartPictures picturesOf(const ChartScene& scene, Device* device, uint32_t side, uint32_t seed);

}  // namespace raig
