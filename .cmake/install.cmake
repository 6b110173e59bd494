# What `cmake --install` leaves behind: bin/vsfind, the libraries, their public headers under include/vsfind/<room>/, and
# the package that find_package(vsfind) reads.
include(CMakePackageConfigHelpers)

block()
set(libraries vsfind_acquisition vsfind_calibration vsfind_calibrate vsfind_finder)

# The packages that the exported targets need, collected from what they link, so that the list cannot go stale.
set(opencv_components "")
set(find_dependencies "")
set(uses_pkgconfig FALSE)
foreach(library IN LISTS libraries)
  get_target_property(linked ${library} LINK_LIBRARIES)
  foreach(item IN LISTS linked)
    if(NOT item OR item MATCHES "^vsfind::|^\\$<BUILD_INTERFACE:|^::@")
      continue()
    elseif(item MATCHES "^opencv_(.+)$")
      list(APPEND opencv_components ${CMAKE_MATCH_1})
    elseif(item MATCHES "^PkgConfig::(.+)$")
      set(uses_pkgconfig TRUE)
      list(APPEND find_dependencies "vsfind_find_module(${CMAKE_MATCH_1} ${${CMAKE_MATCH_1}_MODULE})")
    elseif(item STREQUAL "Eigen3::Eigen")
      list(APPEND find_dependencies "find_dependency(Eigen3 3.3 NO_MODULE)")
    elseif(item MATCHES "^(yaml-cpp|Threads|ZLIB|JPEG|fmt|spdlog|nlohmann_json|hwy)(::.+)?$")
      list(APPEND find_dependencies "find_dependency(${CMAKE_MATCH_1})")
    else()
      message(FATAL_ERROR "${library} links ${item}: say in .cmake/install.cmake which package it comes from")
    endif()
  endforeach()
endforeach()
if(opencv_components)
  list(REMOVE_DUPLICATES opencv_components)
  list(JOIN opencv_components " " opencv_components)
  list(PREPEND find_dependencies "find_dependency(OpenCV 4 COMPONENTS ${opencv_components})")
endif()
if(uses_pkgconfig)
  list(PREPEND find_dependencies "find_dependency(PkgConfig)")
endif()
list(REMOVE_DUPLICATES find_dependencies)
list(JOIN find_dependencies "\n" VSFIND_FIND_DEPENDENCIES)
list(JOIN VSFIND_COMPONENTS " " VSFIND_COMPONENTS)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/vsfind)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/vsfindConfig.cmake.in
  ${PROJECT_BINARY_DIR}/vsfindConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/vsfindConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/vsfindConfig.cmake ${PROJECT_BINARY_DIR}/vsfindConfigVersion.cmake
  DESTINATION ${package_dir})
install(EXPORT vsfindTargets NAMESPACE vsfind:: DESTINATION ${package_dir})

install(TARGETS ${libraries} EXPORT vsfindTargets
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/vsfind)
install(TARGETS vsfind)
endblock()
