# The libraries that an extension carries: ${AJAR_BUNDLE} is laid out by tools/extension/dependencies.py.
function(ajar_bundled target)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} SYSTEM INTERFACE ${AJAR_BUNDLE}/include)
  foreach(pattern ${ARGN})
    file(GLOB library ${AJAR_BUNDLE}/lib/${pattern})
    if(NOT library)
      message(FATAL_ERROR "There is no ${pattern} in ${AJAR_BUNDLE}/lib.")
    endif()
    target_link_libraries(${target} INTERFACE ${library})
  endforeach()
endfunction()

ajar_bundled(embree libembree4*.so*)
set(EMBREE_VERSION_MAJOR 4)
# TBB's headers are the system's: older ones than the library are what TBB promises to serve.
ajar_bundled(TBB::tbb libtbb*.so*)
ajar_bundled(OpenImageIO::OpenImageIO libOpenImageIO.so* libOpenImageIO_Util.so*)
# The module contains what it needs of OpenSubdiv.
include(cmake/opensubdiv_sources.cmake)
ajar_add_opensubdiv(${AJAR_BUNDLE}/opensubdiv)
set(PYBIND11_INCLUDE ${AJAR_BUNDLE}/include)
# Blender runs on systems with an older libstdc++ than the compiler's; ours stays inside the module, unseen.
target_link_options(ajar_options INTERFACE -static-libstdc++ -Wl,--exclude-libs,ALL)
