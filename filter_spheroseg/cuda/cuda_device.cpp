// SPDX-License-Identifier: GPL-3.0-or-later
// The host side of a real GPU. The runtime is linked statically and looks for the driver when it is
// first called, so that the plugin loads where there is none.
#include "anneal_kernels.h"
#include "device.h"
#include "swap_kernels.h"

namespace spheroseg::cuda {

namespace {

constexpr int kLeastMajor = 7;
constexpr int kLeastMinor = 5;

std::string describe(cudaError_t error) {
    return std::string(cudaGetErrorString(error)) + " (" + cudaGetErrorName(error) + ")";
}

/// Frees what CUDA handed out when it goes out of scope.
class Stream {
public:
    Stream() = default;
    ~Stream() {
        if (stream_ != nullptr) {
            cudaStreamDestroy(stream_);
        }
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    cudaError_t create() { return cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking); }
    cudaStream_t get() const { return stream_; }

private:
    cudaStream_t stream_ = nullptr;
};

/// Makes a device the calling thread's current one, and gives the former back at the end.
class CurrentDevice {
public:
    explicit CurrentDevice(int index) {
        known_ = cudaGetDevice(&former_) == cudaSuccess;
        error_ = cudaSetDevice(index);
    }
    ~CurrentDevice() {
        if (known_) {
            cudaSetDevice(former_);
        }
    }
    CurrentDevice(const CurrentDevice&) = delete;
    CurrentDevice& operator=(const CurrentDevice&) = delete;
    cudaError_t error() const { return error_; }

private:
    int former_ = 0;
    bool known_ = false;
    cudaError_t error_ = cudaSuccess;
};

class CudaDevice : public Device {
public:
    CudaDevice(int index, const cudaDeviceProp& properties) : index_(index) {
        info_.name = properties.name;
        info_.multiprocessor_count = properties.multiProcessorCount;
        call("cudaStreamCreateWithFlags", [&] { return stream_.create(); });
    }
    ~CudaDevice() override {
        const CurrentDevice current(index_); // the stream is destroyed on its own device
        cudaStreamSynchronize(stream_.get());
    }

    const DeviceInfo& info() const override { return info_; }

    std::size_t free_bytes() override {
        std::size_t free = 0;
        std::size_t total = 0;
        call("cudaMemGetInfo", [&] { return cudaMemGetInfo(&free, &total); });
        return free;
    }

    void* allocate(std::size_t bytes) override {
        void* memory = nullptr;
        call("cudaMalloc", [&] { return cudaMalloc(&memory, bytes); });
        return memory;
    }

    void release(void* memory) noexcept override {
        const CurrentDevice current(index_);
        cudaFree(memory); // waits for the kernels that use it; an error was reported where it arose
    }

    void clear(void* memory, std::size_t bytes) override {
        call("cudaMemsetAsync", [&] { return cudaMemsetAsync(memory, 0, bytes, stream_.get()); });
    }

    void upload(void* to, const void* from, std::size_t bytes) override {
        copy(to, from, bytes, cudaMemcpyHostToDevice);
    }

    void download(void* to, const void* from, std::size_t bytes) override {
        copy(to, from, bytes, cudaMemcpyDeviceToHost);
    }

    void play_cohesion_tiles(const CohesionArrays& arrays,
                             const TilePhase& phase,
                             int capacity) override {
        call("play_cohesion_tiles",
             [&] { return launch_cohesion_tiles(arrays, phase, capacity, stream_.get()); });
    }

    void measure_bounds(const RefinementArrays& arrays) override {
        call("measure_bounds", [&] { return launch_measure_bounds(arrays, stream_.get()); });
    }

    void play_refinement_batch(const RefinementArrays& arrays, int batch_rounds) override {
        call("play_refinement_batch",
             [&] { return launch_refinement_batch(arrays, batch_rounds, stream_.get()); });
    }

    void
    anneal_groups(const AnnealArrays& arrays, const Phase& phase, const FreeLoads& loads) override {
        call("anneal_groups",
             [&] { return launch_anneal_groups(arrays, phase, loads, stream_.get()); });
    }

    void anneal_groups(const AnnealArrays& arrays,
                       const Phase& phase,
                       const BoundedLoads& loads) override {
        call("exchange_groups",
             [&] { return launch_anneal_groups(arrays, phase, loads, stream_.get()); });
    }

private:
    template <typename Call> void call(const char* name, const Call& call) const {
        const CurrentDevice current(index_);
        const cudaError_t error = current.error() == cudaSuccess ? call() : current.error();
        if (error != cudaSuccess) {
            throw DeviceError(std::string("Expected ") + name + " to succeed on CUDA device " +
                              std::to_string(index_) + " (" + info_.name +
                              "), found: " + describe(error) + ". Use device \"cpu\".");
        }
    }

    void copy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind) const {
        call("cudaMemcpyAsync",
             [&] { return cudaMemcpyAsync(to, from, bytes, kind, stream_.get()); });
        call("cudaStreamSynchronize", [&] { return cudaStreamSynchronize(stream_.get()); });
    }

    int index_;
    DeviceInfo info_;
    Stream stream_;
};

std::string why_no_device(cudaError_t error) {
    int driver = 0;
    if (cudaDriverGetVersion(&driver) == cudaSuccess && driver == 0) {
        return "no NVIDIA driver is installed on this machine";
    }
    if (error == cudaErrorInsufficientDriver) {
        return "the NVIDIA driver is too old: it knows CUDA " + std::to_string(driver / 1000) +
            "." + std::to_string(driver % 1000 / 10) + ", this build needs " +
            std::to_string(CUDART_VERSION / 1000) + "." +
            std::to_string(CUDART_VERSION % 1000 / 10);
    }
    if (error == cudaErrorNoDevice || error == cudaSuccess) {
        return "the NVIDIA driver finds no CUDA device";
    }
    return "CUDA does not start: " + describe(error);
}

/// Why a device can not be used; empty when it can.
std::string defect_of(int index, const cudaDeviceProp& properties) {
    const std::string named = "CUDA device " + std::to_string(index) + " (" + properties.name + ")";
    if (properties.major * 10 + properties.minor < kLeastMajor * 10 + kLeastMinor) {
        return named + " has compute capability " + std::to_string(properties.major) + "." +
            std::to_string(properties.minor) + ", too old: " + std::to_string(kLeastMajor) + "." +
            std::to_string(kLeastMinor) + " or later is needed";
    }
    const CurrentDevice current(index);
    cudaError_t error = current.error();
    if (error == cudaSuccess) {
        error = find_kernel_code();
    }
    return error == cudaSuccess ? "" : named + " can not be used: " + describe(error);
}

} // namespace

DeviceSearch find_device() {
    int count = 0;
    const cudaError_t error = cudaGetDeviceCount(&count);
    if (error != cudaSuccess || count == 0) {
        cudaGetLastError(); // of this failed call, or a later user of the runtime would see it
        return {nullptr, why_no_device(error)};
    }
    std::string reason;
    for (int index = 0; index < count; ++index) {
        cudaDeviceProp properties;
        const cudaError_t found = cudaGetDeviceProperties(&properties, index);
        const std::string defect = found == cudaSuccess
            ? defect_of(index, properties)
            : "CUDA device " + std::to_string(index) + " can not be examined: " + describe(found);
        if (!defect.empty()) {
            cudaGetLastError();
            reason += (reason.empty() ? "" : "; ") + defect;
            continue;
        }
        try {
            return {std::make_unique<CudaDevice>(index, properties), ""};
        } catch (const DeviceError& failure) {
            reason += (reason.empty() ? "" : "; ") + std::string(failure.what());
        }
    }
    return {nullptr, reason};
}

bool built_with_cuda() {
    return true;
}

} // namespace spheroseg::cuda
