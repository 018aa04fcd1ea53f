# The libraries for Windows: ${AJAR_WINDOWS} is laid out by tools/windows/libraries.py. All but Embree are static.
list(APPEND CMAKE_PREFIX_PATH ${AJAR_WINDOWS})
target_include_directories(ajar_options SYSTEM BEFORE INTERFACE ${CMAKE_SOURCE_DIR}/cmake/windows)
target_link_libraries(ajar_options INTERFACE psapi)

find_package(TBB REQUIRED CONFIG)
add_library(embree INTERFACE IMPORTED GLOBAL)
target_include_directories(embree SYSTEM INTERFACE ${AJAR_WINDOWS}/include)
target_link_libraries(embree INTERFACE ${AJAR_WINDOWS}/lib/libajar_embree4.a)
set(EMBREE_VERSION_MAJOR 4)

# In the order of the linker: a library before those that it uses.
add_library(OpenImageIO::OpenImageIO INTERFACE IMPORTED GLOBAL)
target_include_directories(OpenImageIO::OpenImageIO SYSTEM INTERFACE ${AJAR_WINDOWS}/include ${AJAR_WINDOWS}/include/Imath)
target_compile_definitions(OpenImageIO::OpenImageIO INTERFACE OIIO_STATIC_DEFINE)
foreach(name OpenImageIO OpenImageIO_Util OpenColorIO yaml-cpp pystring expat OpenEXR-3_1 OpenEXRCore-3_1 IlmThread-3_1 Iex-3_1 Imath-3_1 tiff jpeg png16 zlibstatic)
  target_link_libraries(OpenImageIO::OpenImageIO INTERFACE ${AJAR_WINDOWS}/lib/lib${name}.a)
endforeach()
target_link_libraries(OpenImageIO::OpenImageIO INTERFACE psapi ws2_32)

include(cmake/opensubdiv_sources.cmake)
ajar_add_opensubdiv(${AJAR_WINDOWS}/opensubdiv)
set(PYBIND11_INCLUDE ${AJAR_WINDOWS}/include)
