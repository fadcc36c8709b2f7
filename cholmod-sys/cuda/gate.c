/* The gate between CHOLMOD and CUDA; see gate.h. */

#define GATE_IMPLEMENTATION
#define _GNU_SOURCE
#include "gate.h"
#include "cublas_v2.h"
#include "cholmod_gpu_kernels.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

/* The device code, as nvcc made it: made by the build script. */
extern const unsigned char gate_kernels [] ;

/* ------------------------------------------------------------------------- */
/* the libraries                                                             */
/* ------------------------------------------------------------------------- */

enum { DRIVER, RUNTIME, BLAS } ;

#define SYMBOL(name) #name
#define POINTER(name, parameters, arguments) cudaError_t (*p_##name) parameters ;
#define POINTER_COPY(name, parameters, arguments, bytes) cudaError_t (*p_##name) parameters ;

/* What was found in them. Written by gate_load alone. */
static struct
{
    GATE_RUNTIME (POINTER)
    GATE_COPIES (POINTER_COPY)
    GATE_CLEANUP (POINTER)
    POINTER (cudaEventQuery, (cudaEvent_t event), )
    POINTER (cudaSetDevice, (int device), )
    POINTER (cudaGetLastError, (void), )
    POINTER (cudaRuntimeGetVersion, (int *version), )
    POINTER (cudaDriverGetVersion, (int *version), )
    POINTER (cudaDeviceGetAttribute, (int *value, enum cudaDeviceAttr attribute, int device), )
    const char *(*p_cudaGetErrorString) (cudaError_t error) ;
    CUresult (*p_cuModuleLoadData) (CUmodule *module, const void *image) ;
    CUresult (*p_cuModuleGetFunction) (CUfunction *f, CUmodule module, const char *name) ;
    CUresult (*p_cuLaunchKernel) (CUfunction f, unsigned int gx, unsigned int gy, unsigned int gz,
        unsigned int bx, unsigned int by, unsigned int bz, unsigned int shared, CUstream s,
        void **parameters, void **extra) ;
    cublasStatus_t (*p_cublasGetProperty) (int property, int *value) ;
    cublasStatus_t (*p_cublasCreate) (cublasHandle_t *handle) ;
    cublasStatus_t (*p_cublasDestroy) (cublasHandle_t handle) ;
    cublasStatus_t (*p_cublasSetStream) (cublasHandle_t handle, cudaStream_t s) ;
    cublasStatus_t (*p_cublasDgemm) (cublasHandle_t handle, cublasOperation_t transa,
        cublasOperation_t transb, int m, int n, int k, const double *alpha, const double *a,
        int lda, const double *b, int ldb, const double *beta, double *c, int ldc) ;
    cublasStatus_t (*p_cublasDsyrk) (cublasHandle_t handle, cublasFillMode_t uplo,
        cublasOperation_t trans, int n, int k, const double *alpha, const double *a, int lda,
        const double *beta, double *c, int ldc) ;
    cublasStatus_t (*p_cublasDtrsm) (cublasHandle_t handle, cublasSideMode_t side,
        cublasFillMode_t uplo, cublasOperation_t trans, cublasDiagType_t diag, int m, int n,
        const double *alpha, const double *a, int lda, double *b, int ldb) ;
} cuda ;

static _Thread_local char complaint [512] ;

static int find (void *library, const char *name, void **where)
{
    *where = dlsym (library, name) ;
    if (*where == NULL)
    {
        snprintf (complaint, sizeof (complaint), "it has no function %s", name) ;
        return 0 ;
    }
    return 1 ;
}

int gate_cuda_major (void)
{
    return CUDART_VERSION / 1000 ;
}

const char *gate_load (int library, const char *path)
{
    void *handle = dlopen (path, RTLD_NOW | RTLD_LOCAL) ;
    if (handle == NULL)
    {
        const char *why = dlerror () ;
        snprintf (complaint, sizeof (complaint), "%s", why ? why : "it cannot be loaded") ;
        return complaint ;
    }
    int found = 1 ;
#define FIND_AS(text, name) found = found && find (handle, text, (void **) &cuda.p_##name) ;
/* Passing the name on lets CUDA's own macros choose the version of a function. */
#define FIND(name, parameters, arguments) \
    found = found && find (handle, SYMBOL (name), (void **) &cuda.p_##name) ;
#define FIND_COPY(name, parameters, arguments, bytes) \
    found = found && find (handle, SYMBOL (name), (void **) &cuda.p_##name) ;
    switch (library)
    {
        case DRIVER:
            FIND (cuModuleLoadData, , )
            FIND (cuModuleGetFunction, , )
            FIND (cuLaunchKernel, , )
            break ;
        case RUNTIME:
            GATE_RUNTIME (FIND)
            GATE_COPIES (FIND_COPY)
            GATE_CLEANUP (FIND)
            FIND (cudaEventQuery, , )
            FIND (cudaSetDevice, , )
            FIND (cudaGetLastError, , )
            FIND (cudaRuntimeGetVersion, , )
            FIND (cudaDriverGetVersion, , )
            FIND (cudaDeviceGetAttribute, , )
            FIND (cudaGetErrorString, , )
            break ;
        default:
            FIND_AS ("cublasCreate_v2", cublasCreate)
            FIND_AS ("cublasDestroy_v2", cublasDestroy)
            FIND_AS ("cublasSetStream_v2", cublasSetStream)
            FIND_AS ("cublasDgemm_v2", cublasDgemm)
            FIND_AS ("cublasDsyrk_v2", cublasDsyrk)
            FIND_AS ("cublasDtrsm_v2", cublasDtrsm)
            FIND_AS ("cublasGetProperty", cublasGetProperty)
    }
    if (!found)
    {
        dlclose (handle) ;
        return complaint ;
    }
    return NULL ;
}

static int version (cudaError_t (*ask) (int *version))
{
    int number = 0 ;
    return ask != NULL && ask (&number) == cudaSuccess ? number : 0 ;
}

int gate_blas_version (void)
{
    int major = 0, minor = 0, patch = 0 ;
    if (cuda.p_cublasGetProperty == NULL) return 0 ;
    cuda.p_cublasGetProperty (0, &major) ;
    cuda.p_cublasGetProperty (1, &minor) ;
    cuda.p_cublasGetProperty (2, &patch) ;
    return major * 10000 + minor * 100 + patch ;
}

int gate_runtime_version (void)
{
    return version (cuda.p_cudaRuntimeGetVersion) ;
}

int gate_driver_version (void)
{
    return version (cuda.p_cudaDriverGetVersion) ;
}

const char *gate_error_text (int error)
{
    return cuda.p_cudaGetErrorString ? cuda.p_cudaGetErrorString ((cudaError_t) error)
                                     : "CUDA's runtime is not loaded" ;
}

/* ------------------------------------------------------------------------- */
/* the ledger                                                                */
/* ------------------------------------------------------------------------- */

/* CHOLMOD calls CUDA from the thread that factorizes. */
static _Thread_local gate_ledger ledger ;

void gate_reset (void)
{
    memset (&ledger, 0, sizeof (ledger)) ;
    /* An error that an earlier call has left is not one of this work. */
    if (cuda.p_cudaGetLastError) cuda.p_cudaGetLastError () ;
}

static void book (const char *function, int error, const char *text)
{
    if (error != 0 && ledger.error == 0)
    {
        ledger.error = error ;
        snprintf (ledger.what, sizeof (ledger.what), "%s: %s", function, text) ;
    }
}

static cudaError_t book_cuda (const char *function, cudaError_t error)
{
    if (error != cudaSuccess) book (function, (int) error, gate_error_text ((int) error)) ;
    return error ;
}

static cublasStatus_t book_blas (const char *function, cublasStatus_t status)
{
    char text [32] ;
    snprintf (text, sizeof (text), "status %d", (int) status) ;
    if (status != CUBLAS_STATUS_SUCCESS) book (function, (int) status, text) ;
    return status ;
}

void gate_read (gate_ledger *out)
{
    /* What is still under way may fail as well. */
    if (ledger.error == 0 && cuda.p_cudaDeviceSynchronize)
    {
        book_cuda ("cudaDeviceSynchronize", cuda.p_cudaDeviceSynchronize ()) ;
    }
    *out = ledger ;
}

/* ------------------------------------------------------------------------- */
/* the runtime                                                               */
/* ------------------------------------------------------------------------- */

#define CLOSED (ledger.error != 0 ? (cudaError_t) ledger.error : cudaErrorInitializationError)

#define FORWARD(name, parameters, arguments) \
cudaError_t gate_##name parameters \
{ \
    if (ledger.error != 0 || cuda.p_##name == NULL) return CLOSED ; \
    return book_cuda (#name, cuda.p_##name arguments) ; \
}
GATE_RUNTIME (FORWARD)

#define FORWARD_COPY(name, parameters, arguments, bytes) \
cudaError_t gate_##name parameters \
{ \
    if (ledger.error != 0 || cuda.p_##name == NULL) return CLOSED ; \
    if (kind == cudaMemcpyHostToDevice) ledger.bytes_to_device += (bytes) ; \
    if (kind == cudaMemcpyDeviceToHost) ledger.bytes_from_device += (bytes) ; \
    return book_cuda (#name, cuda.p_##name arguments) ; \
}
GATE_COPIES (FORWARD_COPY)

#define FORWARD_CLEANUP(name, parameters, arguments) \
cudaError_t gate_##name parameters \
{ \
    return cuda.p_##name == NULL ? CLOSED : cuda.p_##name arguments ; \
}
GATE_CLEANUP (FORWARD_CLEANUP)

/* CHOLMOD asks until a buffer is free: after an error each of them is. */
cudaError_t gate_cudaEventQuery (cudaEvent_t event)
{
    if (ledger.error != 0 || cuda.p_cudaEventQuery == NULL) return cudaSuccess ;
    cudaError_t answer = cuda.p_cudaEventQuery (event) ;
    if (answer == cudaErrorNotReady)
    {
        /* No error, but CUDA keeps it as its last one. */
        cuda.p_cudaGetLastError () ;
        return answer ;
    }
    return book_cuda ("cudaEventQuery", answer) ;
}

/* ------------------------------------------------------------------------- */
/* cuBLAS                                                                    */
/* ------------------------------------------------------------------------- */

#define BLAS_CLOSED CUBLAS_STATUS_NOT_SUPPORTED

/* CHOLMOD makes a handle for each factorization, which takes longer than a small
 * one: handles that it gives back are kept for the next, by device. */
#define DEVICES 64
static cublasHandle_t idle [DEVICES] ;
static pthread_mutex_t idle_lock = PTHREAD_MUTEX_INITIALIZER ;

static int this_device (void)
{
    int device = -1 ;
    if (cuda.p_cudaGetDevice (&device) != cudaSuccess || device >= DEVICES) device = -1 ;
    return device ;
}

cublasStatus_t gate_cublasCreate (cublasHandle_t *handle)
{
    if (ledger.error != 0 || cuda.p_cublasCreate == NULL) return BLAS_CLOSED ;
    int device = this_device () ;
    cublasHandle_t kept = NULL ;
    if (device >= 0)
    {
        pthread_mutex_lock (&idle_lock) ;
        kept = idle [device] ;
        idle [device] = NULL ;
        pthread_mutex_unlock (&idle_lock) ;
    }
    if (kept != NULL)
    {
        *handle = kept ;
        return CUBLAS_STATUS_SUCCESS ;
    }
    return book_blas ("cublasCreate", cuda.p_cublasCreate (handle)) ;
}

cublasStatus_t gate_cublasDestroy (cublasHandle_t handle)
{
    if (cuda.p_cublasDestroy == NULL) return BLAS_CLOSED ;
    int device = ledger.error == 0 ? this_device () : -1 ;
    /* Its streams are destroyed next. */
    if (device >= 0 && cuda.p_cublasSetStream (handle, NULL) == CUBLAS_STATUS_SUCCESS)
    {
        pthread_mutex_lock (&idle_lock) ;
        if (idle [device] == NULL)
        {
            idle [device] = handle ;
            handle = NULL ;
        }
        pthread_mutex_unlock (&idle_lock) ;
    }
    return handle == NULL ? CUBLAS_STATUS_SUCCESS : cuda.p_cublasDestroy (handle) ;
}

cublasStatus_t gate_cublasSetStream (cublasHandle_t handle, cudaStream_t stream)
{
    if (ledger.error != 0 || cuda.p_cublasSetStream == NULL) return BLAS_CLOSED ;
    return book_blas ("cublasSetStream", cuda.p_cublasSetStream (handle, stream)) ;
}

static void count (double flops)
{
    ledger.blas_calls++ ;
    ledger.blas_flops += flops ;
}

cublasStatus_t gate_cublasDgemm (cublasHandle_t handle, cublasOperation_t transa,
    cublasOperation_t transb, int m, int n, int k, const double *alpha, const double *a, int lda,
    const double *b, int ldb, const double *beta, double *c, int ldc)
{
    if (ledger.error != 0 || cuda.p_cublasDgemm == NULL) return BLAS_CLOSED ;
    count (2.0 * m * n * k) ;
    return book_blas ("cublasDgemm", cuda.p_cublasDgemm (handle, transa, transb, m, n, k, alpha,
        a, lda, b, ldb, beta, c, ldc)) ;
}

cublasStatus_t gate_cublasDsyrk (cublasHandle_t handle, cublasFillMode_t uplo,
    cublasOperation_t trans, int n, int k, const double *alpha, const double *a, int lda,
    const double *beta, double *c, int ldc)
{
    if (ledger.error != 0 || cuda.p_cublasDsyrk == NULL) return BLAS_CLOSED ;
    count ((double) n * (n + 1.0) * k) ;
    return book_blas ("cublasDsyrk", cuda.p_cublasDsyrk (handle, uplo, trans, n, k, alpha, a, lda,
        beta, c, ldc)) ;
}

cublasStatus_t gate_cublasDtrsm (cublasHandle_t handle, cublasSideMode_t side,
    cublasFillMode_t uplo, cublasOperation_t trans, cublasDiagType_t diag, int m, int n,
    const double *alpha, const double *a, int lda, double *b, int ldb)
{
    if (ledger.error != 0 || cuda.p_cublasDtrsm == NULL) return BLAS_CLOSED ;
    count (side == CUBLAS_SIDE_RIGHT ? (double) m * n * n : (double) n * m * m) ;
    return book_blas ("cublasDtrsm", cuda.p_cublasDtrsm (handle, side, uplo, trans, diag, m, n,
        alpha, a, lda, b, ldb)) ;
}

#define REFUSE(name) { return book_blas (name, BLAS_CLOSED) ; }

cublasStatus_t gate_cublasZgemm (cublasHandle_t handle, cublasOperation_t transa,
    cublasOperation_t transb, int m, int n, int k, const cuDoubleComplex *alpha,
    const cuDoubleComplex *a, int lda, const cuDoubleComplex *b, int ldb,
    const cuDoubleComplex *beta, cuDoubleComplex *c, int ldc)
REFUSE ("cublasZgemm")

cublasStatus_t gate_cublasZherk (cublasHandle_t handle, cublasFillMode_t uplo,
    cublasOperation_t trans, int n, int k, const double *alpha, const cuDoubleComplex *a, int lda,
    const double *beta, cuDoubleComplex *c, int ldc)
REFUSE ("cublasZherk")

cublasStatus_t gate_cublasZtrsm (cublasHandle_t handle, cublasSideMode_t side,
    cublasFillMode_t uplo, cublasOperation_t trans, cublasDiagType_t diag, int m, int n,
    const cuDoubleComplex *alpha, const cuDoubleComplex *a, int lda, cuDoubleComplex *b, int ldb)
REFUSE ("cublasZtrsm")

/* ------------------------------------------------------------------------- */
/* the device                                                                */
/* ------------------------------------------------------------------------- */

int gate_devices (void)
{
    int count = 0 ;
    if (cuda.p_cudaGetDeviceCount == NULL) return -(int) cudaErrorInitializationError ;
    cudaError_t error = cuda.p_cudaGetDeviceCount (&count) ;
    return error == cudaSuccess ? count : -(int) error ;
}

int gate_use_device (int device, gate_device *out)
{
    struct cudaDeviceProp properties ;
    size_t available = 0, total = 0 ;
    memset (out, 0, sizeof (*out)) ;
    cudaError_t error = cuda.p_cudaSetDevice (device) ;
    if (error == cudaSuccess) error = cuda.p_cudaGetDeviceProperties (&properties, device) ;
    if (error == cudaSuccess) error = cuda.p_cudaMemGetInfo (&available, &total) ;
    if (error != cudaSuccess) return (int) error ;
    snprintf (out->name, sizeof (out->name), "%.255s", properties.name) ;
    out->memory = total ;
    out->memory_free = available ;
    out->compute_major = properties.major ;
    out->compute_minor = properties.minor ;
    out->multiprocessors = properties.multiProcessorCount ;
    if (cuda.p_cudaDeviceGetAttribute (&out->clock_khz, cudaDevAttrClockRate, device)
        != cudaSuccess)
    {
        out->clock_khz = 0 ;
    }
    return 0 ;
}

int gate_allocate (void **device, size_t device_bytes, void **host, size_t host_bytes)
{
    *device = *host = NULL ;
    cudaError_t error = cuda.p_cudaMalloc (device, device_bytes) ;
    if (error == cudaSuccess) error = cuda.p_cudaMallocHost (host, host_bytes) ;
    if (error != cudaSuccess)
    {
        gate_release (*device, *host) ;
        *device = *host = NULL ;
        cuda.p_cudaGetLastError () ;
    }
    return (int) error ;
}

void gate_release (void *device, void *host)
{
    /* After an error copies may still be under way. */
    if (device != NULL || host != NULL) cuda.p_cudaDeviceSynchronize () ;
    if (device != NULL) cuda.p_cudaFree (device) ;
    if (host != NULL) cuda.p_cudaFreeHost (host) ;
}

/* ------------------------------------------------------------------------- */
/* the kernels                                                               */
/* ------------------------------------------------------------------------- */

/* CHOLMOD's kernels are launched by the driver, whose interface has not changed
 * for ten years; what nvcc would put around them changes with each version. */

enum { CREATE_MAP, CREATE_RELATIVE_MAP, ADD_UPDATE, SUM_A, KERNELS } ;

static const char *const kernel_names [KERNELS] =
    { "kernelCreateMap", "kernelCreateRelativeMap", "kernelAddUpdate", "kernelSumA" } ;

static struct { int loaded ; CUfunction function [KERNELS] ; } modules [DEVICES] ;
static pthread_mutex_t modules_lock = PTHREAD_MUTEX_INITIALIZER ;

/* The kernel on the calling thread's device; NULL, and booked, if that fails. */
static CUfunction kernel (int which)
{
    int device = 0 ;
    if (book_cuda ("cudaGetDevice", cuda.p_cudaGetDevice (&device)) != cudaSuccess) return NULL ;
    if (device < 0 || device >= DEVICES)
    {
        book ("cudaGetDevice", (int) cudaErrorInvalidDevice, "a device beyond the 64th") ;
        return NULL ;
    }
    pthread_mutex_lock (&modules_lock) ;
    if (!modules [device].loaded)
    {
        CUmodule module ;
        CUresult error = cuda.p_cuModuleLoadData (&module, gate_kernels) ;
        for (int k = 0 ; k < KERNELS && error == CUDA_SUCCESS ; k++)
        {
            error = cuda.p_cuModuleGetFunction (&modules [device].function [k], module,
                kernel_names [k]) ;
        }
        if (error != CUDA_SUCCESS)
        {
            book ("cuModuleLoadData", (int) error, "the device code cannot be loaded") ;
        }
        modules [device].loaded = error == CUDA_SUCCESS ;
    }
    CUfunction found = modules [device].loaded ? modules [device].function [which] : NULL ;
    pthread_mutex_unlock (&modules_lock) ;
    return found ;
}

static int launch (int which, int64_t rows, int64_t columns, unsigned int block_rows,
    unsigned int block_columns, cudaStream_t stream, void **parameters)
{
    if (ledger.error != 0 || cuda.p_cuLaunchKernel == NULL) return 0 ;
    CUfunction f = kernel (which) ;
    if (f == NULL) return 0 ;
    unsigned int gx = (unsigned int) ((rows + block_rows - 1) / block_rows) ;
    unsigned int gy = (unsigned int) ((columns + block_columns - 1) / block_columns) ;
    CUresult error = cuda.p_cuLaunchKernel (f, gx, gy, 1, block_rows, block_columns, 1, 0,
        (CUstream) stream, parameters, NULL) ;
    if (error != CUDA_SUCCESS) book ("cuLaunchKernel", (int) error, kernel_names [which]) ;
    return 0 ;
}

int createMapOnDevice (int64_t *d_Map, int64_t *d_Ls, int64_t psi, int64_t nsrow)
{
    void *parameters [ ] = { &d_Map, &d_Ls, &psi, &nsrow } ;
    return launch (CREATE_MAP, nsrow, 1, 32, 1, NULL, parameters) ;
}

int createRelativeMapOnDevice (int64_t *d_Map, int64_t *d_Ls, int64_t *d_RelativeMap, int64_t pdi1,
    int64_t ndrow, cudaStream_t *stream)
{
    void *parameters [ ] = { &d_Map, &d_Ls, &d_RelativeMap, &pdi1, &ndrow } ;
    return launch (CREATE_RELATIVE_MAP, ndrow, 1, 256, 1, *stream, parameters) ;
}

int addUpdateOnDevice (double *d_A, double *d_C, int64_t *d_RelativeMap, int64_t ndrow1,
    int64_t ndrow2, int64_t nsrow, cudaStream_t *stream)
{
    void *parameters [ ] = { &d_A, &d_C, &d_RelativeMap, &ndrow1, &ndrow2, &nsrow } ;
    return launch (ADD_UPDATE, ndrow2, ndrow1, 16, 16, *stream, parameters) ;
}

int sumAOnDevice (double *a1, double *a2, const double alpha, int nsrow, int nscol)
{
    double factor = alpha ;
    void *parameters [ ] = { &a1, &a2, &factor, &nsrow, &nscol } ;
    return launch (SUM_A, nsrow, nscol, 16, 16, NULL, parameters) ;
}

/* Complex matrices are never factored here. */

int addComplexUpdateOnDevice (double *d_A, double *d_C, int64_t *d_RelativeMap, int64_t ndrow1,
    int64_t ndrow2, int64_t nsrow, cudaStream_t *stream)
{
    book ("addComplexUpdateOnDevice", (int) cudaErrorNotSupported, "no complex matrices") ;
    return 0 ;
}

int sumComplexAOnDevice (double *a1, double *a2, const double alpha, int nsrow, int nscol)
{
    book ("sumComplexAOnDevice", (int) cudaErrorNotSupported, "no complex matrices") ;
    return 0 ;
}
