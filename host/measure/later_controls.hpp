/// The controls of the later cases: how rays leave surfaces, and spheres.
#pragma once

#include "measure/controls.hpp"

namespace raig {

std::vector<Control> laterControls();

}  // namespace raig
