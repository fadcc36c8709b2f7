/* The runtime: memory is the host's, streams and events do nothing, because
 * everything is done when a call returns. */

#include <cuda_runtime_api.h>
#include <pthread.h>
#include "standin.h"

/* Blocks that were handed out, with their sizes: there are a handful. */
#define BLOCKS 4096
static struct { void *p ; size_t size ; } blocks [BLOCKS] ;
static size_t in_use ;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER ;

static size_t memory (void)
{
    const char *wish = getenv ("CUDA_STANDIN_MEMORY") ;
    return wish ? strtoull (wish, NULL, 10) : (size_t) 1 << 30 ;
}

cudaError_t cudaGetDeviceCount (int *count)
{
    MAY_FAIL (cudaError_t) ;
    *count = 1 ;
    return cudaSuccess ;
}

cudaError_t cudaGetDevice (int *device)
{
    MAY_FAIL (cudaError_t) ;
    *device = 0 ;
    return cudaSuccess ;
}

cudaError_t cudaSetDevice (int device)
{
    MAY_FAIL (cudaError_t) ;
    return device == 0 ? cudaSuccess : cudaErrorInvalidDevice ;
}

cudaError_t cudaGetDeviceProperties (struct cudaDeviceProp *p, int device)
{
    MAY_FAIL (cudaError_t) ;
    memset (p, 0, sizeof (*p)) ;
    strcpy (p->name, "stand-in for CUDA on the CPU (for tests, no GPU)") ;
    p->totalGlobalMem = memory () ;
    p->major = 9 ;
    p->multiProcessorCount = 1 ;
    return device == 0 ? cudaSuccess : cudaErrorInvalidDevice ;
}

cudaError_t cudaDeviceGetAttribute (int *value, enum cudaDeviceAttr attribute, int device)
{
    MAY_FAIL (cudaError_t) ;
    (void) attribute ;
    *value = 0 ;
    return device == 0 ? cudaSuccess : cudaErrorInvalidDevice ;
}

cudaError_t cudaRuntimeGetVersion (int *version)
{
    MAY_FAIL (cudaError_t) ;
    *version = CUDART_VERSION ;
    return cudaSuccess ;
}

cudaError_t cudaDriverGetVersion (int *version)
{
    MAY_FAIL (cudaError_t) ;
    *version = CUDART_VERSION ;
    return cudaSuccess ;
}

const char *cudaGetErrorString (cudaError_t error)
{
    return error == cudaErrorInsufficientDriver ? "CUDA driver version is insufficient"
        : error == cudaErrorMemoryAllocation ? "out of memory"
        : error == cudaErrorNoDevice ? "no CUDA-capable device is detected"
        : "an error of the stand-in" ;
}

cudaError_t cudaGetLastError (void)
{
    MAY_FAIL (cudaError_t) ;
    return cudaSuccess ;
}

cudaError_t cudaMemGetInfo (size_t *available, size_t *total)
{
    MAY_FAIL (cudaError_t) ;
    pthread_mutex_lock (&lock) ;
    *total = memory () ;
    *available = *total > in_use ? *total - in_use : 0 ;
    pthread_mutex_unlock (&lock) ;
    return cudaSuccess ;
}

cudaError_t cudaMalloc (void **p, size_t size)
{
    MAY_FAIL (cudaError_t) ;
    cudaError_t error = cudaErrorMemoryAllocation ;
    pthread_mutex_lock (&lock) ;
    for (int k = 0 ; k < BLOCKS && in_use + size <= memory () ; k++)
    {
        if (blocks [k].p != NULL) continue ;
        blocks [k].p = *p = aligned_alloc (256, (size + 255) / 256 * 256) ;
        if (*p == NULL) break ;
        /* What nobody wrote must not look like a result. */
        memset (*p, 0xff, size) ;
        blocks [k].size = size ;
        in_use += size ;
        error = cudaSuccess ;
        break ;
    }
    pthread_mutex_unlock (&lock) ;
    return error ;
}

cudaError_t cudaFree (void *p)
{
    MAY_FAIL (cudaError_t) ;
    cudaError_t error = p == NULL ? cudaSuccess : cudaErrorInvalidValue ;
    pthread_mutex_lock (&lock) ;
    for (int k = 0 ; k < BLOCKS && p != NULL ; k++)
    {
        if (blocks [k].p != p) continue ;
        in_use -= blocks [k].size ;
        blocks [k].p = NULL ;
        free (p) ;
        error = cudaSuccess ;
        break ;
    }
    pthread_mutex_unlock (&lock) ;
    return error ;
}

cudaError_t cudaMallocHost (void **p, size_t size)
{
    MAY_FAIL (cudaError_t) ;
    *p = aligned_alloc (4096, (size + 4095) / 4096 * 4096) ;
    if (*p == NULL) return cudaErrorMemoryAllocation ;
    memset (*p, 0xff, size) ;
    return cudaSuccess ;
}

cudaError_t cudaFreeHost (void *p)
{
    MAY_FAIL (cudaError_t) ;
    free (p) ;
    return cudaSuccess ;
}

cudaError_t cudaMemset (void *p, int value, size_t size)
{
    MAY_FAIL (cudaError_t) ;
    memset (p, value, size) ;
    return cudaSuccess ;
}

cudaError_t cudaMemcpy (void *to, const void *from, size_t size, enum cudaMemcpyKind kind)
{
    MAY_FAIL (cudaError_t) ;
    (void) kind ;
    memcpy (to, from, size) ;
    return cudaSuccess ;
}

cudaError_t cudaMemcpyAsync (void *to, const void *from, size_t size, enum cudaMemcpyKind kind,
    cudaStream_t stream)
{
    MAY_FAIL (cudaError_t) ;
    (void) kind, (void) stream ;
    memcpy (to, from, size) ;
    return cudaSuccess ;
}

cudaError_t cudaMemcpy2DAsync (void *to, size_t to_pitch, const void *from, size_t from_pitch,
    size_t width, size_t height, enum cudaMemcpyKind kind, cudaStream_t stream)
{
    MAY_FAIL (cudaError_t) ;
    (void) kind, (void) stream ;
    for (size_t row = 0 ; row < height ; row++)
    {
        memcpy ((char *) to + row * to_pitch, (const char *) from + row * from_pitch, width) ;
    }
    return cudaSuccess ;
}

cudaError_t cudaDeviceSynchronize (void)
{
    MAY_FAIL (cudaError_t) ;
    return cudaSuccess ;
}

cudaError_t cudaStreamCreate (cudaStream_t *stream)
{
    MAY_FAIL (cudaError_t) ;
    *stream = malloc (1) ;
    return *stream ? cudaSuccess : cudaErrorMemoryAllocation ;
}

cudaError_t cudaStreamDestroy (cudaStream_t stream)
{
    MAY_FAIL (cudaError_t) ;
    free (stream) ;
    return cudaSuccess ;
}

cudaError_t cudaStreamSynchronize (cudaStream_t stream)
{
    MAY_FAIL (cudaError_t) ;
    (void) stream ;
    return cudaSuccess ;
}

cudaError_t cudaStreamWaitEvent (cudaStream_t stream, cudaEvent_t event, unsigned int flags)
{
    MAY_FAIL (cudaError_t) ;
    (void) stream, (void) event, (void) flags ;
    return cudaSuccess ;
}

cudaError_t cudaEventCreateWithFlags (cudaEvent_t *event, unsigned int flags)
{
    MAY_FAIL (cudaError_t) ;
    (void) flags ;
    *event = malloc (1) ;
    return *event ? cudaSuccess : cudaErrorMemoryAllocation ;
}

cudaError_t cudaEventDestroy (cudaEvent_t event)
{
    MAY_FAIL (cudaError_t) ;
    free (event) ;
    return cudaSuccess ;
}

cudaError_t cudaEventRecord (cudaEvent_t event, cudaStream_t stream)
{
    MAY_FAIL (cudaError_t) ;
    (void) event, (void) stream ;
    return cudaSuccess ;
}

/* Now and then not ready, as a device that has much to do: CHOLMOD then gives
 * work to the CPU, and both must come to the same. */
cudaError_t cudaEventQuery (cudaEvent_t event)
{
    MAY_FAIL (cudaError_t) ;
    static atomic_long asked ;
    (void) event ;
    return ++asked % 3 == 0 ? cudaErrorNotReady : cudaSuccess ;
}

cudaError_t cudaEventSynchronize (cudaEvent_t event)
{
    MAY_FAIL (cudaError_t) ;
    (void) event ;
    return cudaSuccess ;
}
