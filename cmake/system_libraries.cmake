# Embree, TBB, OpenImageIO and OpenSubdiv of the system.
find_package(TBB REQUIRED)
# Debian's OpenImageIO package configuration demands its command-line tools; the library is all we use.
find_path(OPENIMAGEIO_INCLUDE OpenImageIO/imageio.h REQUIRED)
find_library(OPENIMAGEIO_LIBRARY OpenImageIO REQUIRED)
find_library(OPENIMAGEIO_UTIL_LIBRARY OpenImageIO_Util REQUIRED)
add_library(OpenImageIO::OpenImageIO INTERFACE IMPORTED)
target_include_directories(OpenImageIO::OpenImageIO SYSTEM INTERFACE ${OPENIMAGEIO_INCLUDE})
target_link_libraries(OpenImageIO::OpenImageIO INTERFACE ${OPENIMAGEIO_LIBRARY} ${OPENIMAGEIO_UTIL_LIBRARY})
find_package(embree 4 QUIET)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED)
endif()
# The package configuration of OpenSubdiv demands its library for graphics cards; that for processors is all we use.
find_path(OPENSUBDIV_INCLUDE opensubdiv/far/patchTable.h REQUIRED)
find_library(OPENSUBDIV_LIBRARY osdCPU REQUIRED)
add_library(OpenSubdiv::OpenSubdiv INTERFACE IMPORTED)
target_include_directories(OpenSubdiv::OpenSubdiv SYSTEM INTERFACE ${OPENSUBDIV_INCLUDE})
target_link_libraries(OpenSubdiv::OpenSubdiv INTERFACE ${OPENSUBDIV_LIBRARY})
