// volk, which loads Vulkan's entry points at run time, as Debian packages it: in source.
#include <volk.c>
