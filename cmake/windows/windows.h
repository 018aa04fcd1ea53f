// Windows' header without its macros for memory models of 16 bits, which TBB's headers would bring into every file: `near` and `far` are names in Ajar.
#pragma once

#include_next <windows.h>

#undef near
#undef far
#undef NEAR
#undef FAR
#define NEAR
#define FAR
