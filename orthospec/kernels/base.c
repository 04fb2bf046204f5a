/* The kernels for what every processor of the platform can do. */
#include "kernels.h"

#define VARIANT kernels_base
#define NAME "base"
#include "variant.h"
