/* The gate between CHOLMOD and CUDA.
 *
 * CHOLMOD calls the functions below under CUDA's names. They find CUDA's
 * libraries when they are first needed, so that a program with GPU support
 * starts on any machine; they keep a ledger of what went to the device; and
 * after the first error they let no further work through: CHOLMOD ignores many
 * of CUDA's answers, and what it computes after an error is worth nothing.
 *
 * Forced into each of CHOLMOD's files by the build script. */
#ifndef DEMPFV_GATE_H
#define DEMPFV_GATE_H

/* First, so that their own macros are set before the names change below. */
#include <cuda.h>
#include <cuda_runtime_api.h>
#include <stdint.h>

/* What went through the gate since gate_reset, on the calling thread. */
typedef struct
{
    uint64_t bytes_to_device ;
    uint64_t bytes_from_device ;
    uint64_t blas_calls ;
    double blas_flops ;
    /* The first error: 0 if there is none, else CUDA's or cuBLAS's number. */
    int error ;
    /* Which function gave it, and what CUDA calls it. */
    char what [160] ;
} gate_ledger ;

/* A device, as CUDA describes it. */
typedef struct
{
    char name [256] ;
    uint64_t memory ;           /* bytes */
    uint64_t memory_free ;      /* bytes */
    int compute_major ;
    int compute_minor ;
    int multiprocessors ;
    int clock_khz ;             /* highest of the processors; 0 if unknown */
} gate_device ;

/* Major version of CUDA that the gate was built with; only libraries of the
 * same are of use. */
int gate_cuda_major (void) ;

/* Loads a library from a path or a name: 0 the driver, 1 the runtime, 2 cuBLAS.
 * Returns NULL, or why it is of no use; the text lives until the next call on
 * this thread. Not to be called by two threads at once. */
const char *gate_load (int library, const char *path) ;

/* Versions of the loaded libraries, as CUDA numbers them (13000 is 13.0); 0 if
 * unknown. */
int gate_runtime_version (void) ;
int gate_driver_version (void) ;
/* That of cuBLAS as 10000 major + 100 minor + patch; 0 if unknown. */
int gate_blas_version (void) ;

void gate_reset (void) ;
void gate_read (gate_ledger *ledger) ;

/* Number of devices; negative (CUDA's error) if there is none to be had. */
int gate_devices (void) ;

/* Makes a device the calling thread's and describes it. 0, or CUDA's error. */
int gate_use_device (int device, gate_device *description) ;

/* What CUDA calls an error of its runtime. */
const char *gate_error_text (int error) ;

/* Memory for CHOLMOD's pools: on the device, and on the host, where the device
 * can reach it. 0, or CUDA's error. */
int gate_allocate (void **device, size_t device_bytes, void **host, size_t host_bytes) ;
void gate_release (void *device, void *host) ;

#define GATE_RUNTIME(X) \
    X (cudaGetDeviceCount, (int *count), (count)) \
    X (cudaGetDevice, (int *device), (device)) \
    X (cudaGetDeviceProperties, (struct cudaDeviceProp *p, int device), (p, device)) \
    X (cudaMemGetInfo, (size_t *available, size_t *total), (available, total)) \
    X (cudaMalloc, (void **p, size_t size), (p, size)) \
    X (cudaMallocHost, (void **p, size_t size), (p, size)) \
    X (cudaMemset, (void *p, int value, size_t size), (p, value, size)) \
    X (cudaDeviceSynchronize, (void), ()) \
    X (cudaStreamCreate, (cudaStream_t *s), (s)) \
    X (cudaStreamSynchronize, (cudaStream_t s), (s)) \
    X (cudaStreamWaitEvent, (cudaStream_t s, cudaEvent_t e, unsigned int flags), (s, e, flags)) \
    X (cudaEventCreateWithFlags, (cudaEvent_t *e, unsigned int flags), (e, flags)) \
    X (cudaEventRecord, (cudaEvent_t e, cudaStream_t s), (e, s)) \
    X (cudaEventSynchronize, (cudaEvent_t e), (e))

/* Counted by the bytes that they move. */
#define GATE_COPIES(X) \
    X (cudaMemcpy, (void *to, const void *from, size_t size, enum cudaMemcpyKind kind), \
        (to, from, size, kind), size) \
    X (cudaMemcpyAsync, (void *to, const void *from, size_t size, enum cudaMemcpyKind kind, \
        cudaStream_t s), (to, from, size, kind, s), size) \
    X (cudaMemcpy2DAsync, (void *to, size_t to_pitch, const void *from, size_t from_pitch, \
        size_t width, size_t height, enum cudaMemcpyKind kind, cudaStream_t s), \
        (to, to_pitch, from, from_pitch, width, height, kind, s), width * height)

/* Let through after an error too: they give back what is held. */
#define GATE_CLEANUP(X) \
    X (cudaFree, (void *p), (p)) \
    X (cudaFreeHost, (void *p), (p)) \
    X (cudaStreamDestroy, (cudaStream_t s), (s)) \
    X (cudaEventDestroy, (cudaEvent_t e), (e))

#define GATE_DECLARE(name, parameters, arguments) cudaError_t gate_##name parameters ;
#define GATE_DECLARE_COPY(name, parameters, arguments, bytes) cudaError_t gate_##name parameters ;
GATE_RUNTIME (GATE_DECLARE)
GATE_COPIES (GATE_DECLARE_COPY)
GATE_CLEANUP (GATE_DECLARE)
cudaError_t gate_cudaEventQuery (cudaEvent_t event) ;

#ifndef GATE_IMPLEMENTATION
/* Older versions of CUDA make some of these macros themselves. */
#undef cudaGetDeviceProperties
#define cudaGetDeviceCount gate_cudaGetDeviceCount
#define cudaGetDevice gate_cudaGetDevice
#define cudaGetDeviceProperties gate_cudaGetDeviceProperties
#define cudaMemGetInfo gate_cudaMemGetInfo
#define cudaMalloc gate_cudaMalloc
#define cudaMallocHost gate_cudaMallocHost
#define cudaMemset gate_cudaMemset
#define cudaDeviceSynchronize gate_cudaDeviceSynchronize
#define cudaStreamCreate gate_cudaStreamCreate
#define cudaStreamSynchronize gate_cudaStreamSynchronize
#define cudaStreamWaitEvent gate_cudaStreamWaitEvent
#define cudaEventCreateWithFlags gate_cudaEventCreateWithFlags
#define cudaEventRecord gate_cudaEventRecord
#define cudaEventSynchronize gate_cudaEventSynchronize
#define cudaEventQuery gate_cudaEventQuery
#define cudaMemcpy gate_cudaMemcpy
#define cudaMemcpyAsync gate_cudaMemcpyAsync
#define cudaMemcpy2DAsync gate_cudaMemcpy2DAsync
#define cudaFree gate_cudaFree
#define cudaFreeHost gate_cudaFreeHost
#define cudaStreamDestroy gate_cudaStreamDestroy
#define cudaEventDestroy gate_cudaEventDestroy
#endif

#endif
