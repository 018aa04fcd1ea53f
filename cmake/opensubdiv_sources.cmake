# Adds ajar_opensubdiv: the part of OpenSubdiv in `folder` that describes and evaluates surfaces.
function(ajar_add_opensubdiv folder)
  file(GLOB opensubdiv_sources ${folder}/opensubdiv/*/*.cpp)
  add_library(ajar_opensubdiv STATIC ${opensubdiv_sources})
  target_include_directories(ajar_opensubdiv SYSTEM PUBLIC ${folder})
  target_compile_options(ajar_opensubdiv PRIVATE -w -march=${AJAR_ARCH})
  set_target_properties(ajar_opensubdiv PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON CXX_STANDARD 14)
  add_library(OpenSubdiv::OpenSubdiv ALIAS ajar_opensubdiv)
endfunction()
