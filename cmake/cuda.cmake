# The GPU engine: with SPHEROSEG_CUDA its kernels, else a stand-in that says that there are none.
set(SPHEROSEG_CUDA_FOLDER ${CMAKE_SOURCE_DIR}/filter_spheroseg/cuda)

if(SPHEROSEG_CUDA)
    if(SPHEROSEG_SANITIZE OR SPHEROSEG_SANITIZE_THREAD OR SPHEROSEG_BUILD_FUZZERS)
        message(FATAL_ERROR "The sanitizers and fuzzers do not build with SPHEROSEG_CUDA. Configure "
            "with -DSPHEROSEG_CUDA=OFF: the kernels' own source is tested by emulation there.")
    endif()
    include(CheckLanguage)
    check_language(CUDA)
    if(NOT CMAKE_CUDA_COMPILER)
        message(FATAL_ERROR "SPHEROSEG_CUDA is ON, but nvcc was not found. Put it on the PATH, set "
            "CUDACXX, or configure with -DSPHEROSEG_CUDA=OFF.")
    endif()
    if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
        # Machine code for Turing to Hopper, and PTX that the driver compiles for later ones.
        set(CMAKE_CUDA_ARCHITECTURES
            75-real 80-real 86-real 89-real 90-real 90-virtual)
    endif()
    enable_language(CUDA)
    find_package(CUDAToolkit REQUIRED)
    message(STATUS "GPU engine: CUDA ${CUDAToolkit_VERSION} for ${CMAKE_CUDA_ARCHITECTURES}")
else()
    message(STATUS "GPU engine: none (SPHEROSEG_CUDA is OFF)")
endif()

function(add_gpu_engine target)
    target_sources(${target} PRIVATE ${SPHEROSEG_CUDA_FOLDER}/device.cpp
        ${SPHEROSEG_CUDA_FOLDER}/device_groups.cpp ${SPHEROSEG_CUDA_FOLDER}/device_swaps.cpp)
    target_include_directories(${target} PUBLIC ${SPHEROSEG_CUDA_FOLDER})
    if(NOT SPHEROSEG_CUDA)
        target_sources(${target} PRIVATE ${SPHEROSEG_CUDA_FOLDER}/no_device.cpp)
        return()
    endif()
    target_sources(${target} PRIVATE
        ${SPHEROSEG_CUDA_FOLDER}/anneal_kernels.cu ${SPHEROSEG_CUDA_FOLDER}/cuda_device.cpp
        ${SPHEROSEG_CUDA_FOLDER}/swap_kernels.cu)
    # Results must equal the cores': no contraction to fused multiply-add, no fast math, neither in
    # kernels nor in what nvcc has the host compiler make of the headers.
    target_compile_options(${target} PRIVATE
        "$<$<COMPILE_LANGUAGE:CUDA>:--fmad=false;-Xcompiler=-Wall,-Wextra,-ffp-contract=off>"
        $<$<AND:$<BOOL:${SPHEROSEG_WERROR}>,$<COMPILE_LANGUAGE:CUDA>>:--Werror=all-warnings>)
    set_target_properties(${target} PROPERTIES
        CUDA_STANDARD 17
        CUDA_STANDARD_REQUIRED ON
        CUDA_VISIBILITY_PRESET hidden
        CUDA_RUNTIME_LIBRARY Static)
    # Static: the plugin loads on machines without a driver, and needs no library of CUDA's.
    target_link_libraries(${target} PRIVATE CUDA::cudart_static)
endfunction()
