# Configures projects against packages that claim to be other versions of Eigen and OpenCV. Nothing is compiled: what is
# tried is which versions and components are accepted, and what is said of the others.
set(project "${CMAKE_CURRENT_LIST_DIR}/versions")
file(REMOVE_RECURSE "${WORK}")

# fake_package(NAME VERSION VERSION_FILE)
function(fake_package name version version_file)
  set(folder "${WORK}/${name}-${version}")
  configure_file("${project}/fake/${name}Config.cmake.in" "${folder}/${name}Config.cmake" @ONLY)
  configure_file("${project}/fake/ConfigVersion.cmake.in" "${folder}/${version_file}" @ONLY)
endfunction()
foreach(version 3.2.10 3.3.0 5.0.0)
  fake_package(Eigen3 ${version} Eigen3ConfigVersion.cmake)
endforeach()
set(modules core imgproc video imgcodecs calib3d features2d dnn)
foreach(version 3.4.0 4.1.2 4.2.0)
  fake_package(OpenCV ${version} OpenCVConfig-version.cmake)
endforeach()
set(modules core imgproc video imgcodecs features dnn)
fake_package(OpenCV 5.0.0 OpenCVConfig-version.cmake)

# expect(WHAT_IS_PRINTED FOLDER ARGUMENTS...)
set(number 0)
function(expect wanted source)
  math(EXPR number "${number} + 1")
  set(number ${number} PARENT_SCOPE)
  execute_process(COMMAND ${CMAKE_COMMAND} -S "${source}" -B "${WORK}/${number}" -G ${GENERATOR}
                          -DCMAKE_CXX_COMPILER=${COMPILER} ${ARGN}
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(NOT output MATCHES "${wanted}")
    message(FATAL_ERROR "not found: ${wanted}\nin: ${output}")
  endif()
endfunction()

execute_process(COMMAND ${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix" --component development
                OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
function(expect_installed wanted eigen opencv components)
  expect("${wanted}" "${project}" -DCMAKE_PREFIX_PATH=${WORK}/prefix -DEigen3_DIR=${WORK}/Eigen3-${eigen}
         -DOpenCV_DIR=${WORK}/OpenCV-${opencv} -DCOMPONENTS=${components})
  set(number ${number} PARENT_SCOPE)
endfunction()
expect_installed("accepted: Eigen 3.3.0, OpenCV 4.2.0" 3.3.0 4.2.0 filters)
expect_installed("accepted: Eigen 5.0.0, OpenCV 5.0.0" 5.0.0 5.0.0 "filters,hosts")
expect_installed("Eigen3 3.2.10 in [^ ]* is older than 3.3[.]" 3.2.10 4.2.0 filters)
expect_installed("OpenCV 4.1.2 in [^ ]* is older than 4.2[.]" 3.3.0 4.1.2 filters)
expect_installed("OpenCV 3.4.0 in [^ ]* is older than 4.2[.]" 3.3.0 3.4.0 filters)
expect_installed("no component \"filtres\". This installation has: core, .*, filters, pipeline," 3.3.0 4.2.0
                 "core,filtres")

function(expect_source wanted eigen opencv)
  expect("${wanted}" ${ARGN} -DEigen3_DIR=${WORK}/Eigen3-${eigen} -DOpenCV_DIR=${WORK}/OpenCV-${opencv})
  set(number ${number} PARENT_SCOPE)
endfunction()
set(subproject "${project}" -DDYNFILTER_SOURCE=${SOURCE})
expect_source("accepted: Eigen 5.0.0, OpenCV 5.0.0" 5.0.0 5.0.0 ${subproject})
expect_source("Eigen3 3.2.10 in [^ ]* is older than 3.3[.]" 3.2.10 4.2.0 ${subproject})
expect_source("only example 01 is built.* Generating done" 5.0.0 5.0.0 "${SOURCE}" -DDYNFILTER_BUILD_TESTS=OFF)
expect_source("the tests need OpenCV's modules calib3d and features2d.*-DDYNFILTER_BUILD_TESTS=OFF" 5.0.0 5.0.0 "${SOURCE}")
