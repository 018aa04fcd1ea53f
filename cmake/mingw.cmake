# Compiles for 64-bit Windows on Debian, by the mingw-w64 with POSIX threads. AJAR_WINDOWS is the prefix of the libraries, which tools/windows makes.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES AJAR_WINDOWS)
set(CMAKE_FIND_ROOT_PATH ${AJAR_WINDOWS} /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(PKG_CONFIG_EXECUTABLE "")
# Windows aligns the stack to 16 bytes, and GCC's moves of 32 bytes to the stack demand 32 (its bug 54412): the assembler writes moves that do not.
# Strict C++ leaves out M_PI without the definition.
set(portable "-Wa,-muse-unaligned-vector-move -D_USE_MATH_DEFINES -D_WIN32_WINNT=0x0A00 -DNOMINMAX -DWIN32_LEAN_AND_MEAN")
set(CMAKE_C_FLAGS_INIT "${portable}")
set(CMAKE_CXX_FLAGS_INIT "${portable}")
# The libraries of the compiler are inside each program.
foreach(kind EXE MODULE SHARED)
  set(CMAKE_${kind}_LINKER_FLAGS_INIT "-static")
endforeach()
