/// The controls of the cases that pictures show: what is left out and not told, and numbers that are none.
#pragma once

#include "measure/controls.hpp"

namespace raig {

std::vector<Control> pictureControls();

}  // namespace raig
