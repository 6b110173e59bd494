# The test package.consumer; tests/package/CMakeLists.txt says with what it is called.

# run(WHAT command…): stops the test where the command fails.
function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed (${result}):\n${output}")
  endif()
  message(STATUS "${what}: done")
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
run("install" ${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${WORK}/first)
# Elsewhere, with a space in the name: the package must not remember where it was installed first.
set(prefix "${WORK}/moved here")
file(RENAME ${WORK}/first ${prefix})

# Nor where it was built.
file(GLOB package_files "${prefix}/${LIBDIR}/cmake/vsfind/*.cmake")
if(NOT package_files)
  message(FATAL_ERROR "no package in ${prefix}/${LIBDIR}/cmake/vsfind")
endif()
foreach(package_file IN LISTS package_files)
  file(READ ${package_file} text)
  foreach(path ${SOURCE} ${BUILD} ${WORK})
    string(FIND "${text}" "${path}" where)
    if(NOT where EQUAL -1)
      message(FATAL_ERROR "${package_file} names ${path}")
    endif()
  endforeach()
endforeach()

foreach(room acquisition calibration finder)
  file(GLOB headers "${prefix}/include/vsfind/${room}/*.h")
  if(NOT headers)
    message(FATAL_ERROR "no header in ${prefix}/include/vsfind/${room}")
  endif()
endforeach()
run("the installed program" "${prefix}/bin/vsfind" --help)

run("configuring the consumer" ${CMAKE_COMMAND} -S ${SOURCE}/tests/package/consumer -B ${WORK}/consumer -G Ninja
  -D CMAKE_PREFIX_PATH=${prefix} -D HEADERS=${prefix}/include/vsfind -D CMAKE_BUILD_TYPE=${CONFIG}
  -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -D CMAKE_CXX_FLAGS=${FLAGS})
file(STRINGS ${WORK}/consumer/CMakeCache.txt found REGEX "^vsfind_DIR:")
if(NOT found STREQUAL "vsfind_DIR:PATH=${prefix}/${LIBDIR}/cmake/vsfind")
  message(FATAL_ERROR "another vsfind was found: ${found}")
endif()
run("building the consumer" ${CMAKE_COMMAND} --build ${WORK}/consumer)
run("the acquisition library" ${WORK}/consumer/use_acquisition ${WORK})
run("the calibration library" ${WORK}/consumer/use_calibration)
run("the calibrate library" ${WORK}/consumer/use_calibrate)
run("the finder library" ${WORK}/consumer/use_finder)
