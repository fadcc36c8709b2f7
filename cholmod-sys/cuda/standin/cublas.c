/* cuBLAS: the host's BLAS under its names. */

#define GATE_IMPLEMENTATION
#include <cublas_v2.h>
#include "standin.h"

void dgemm_ (const char *, const char *, const int *, const int *, const int *, const double *,
    const double *, const int *, const double *, const int *, const double *, double *, const int *) ;
void dsyrk_ (const char *, const char *, const int *, const int *, const double *, const double *,
    const int *, const double *, double *, const int *) ;
void dtrsm_ (const char *, const char *, const char *, const char *, const int *, const int *,
    const double *, const double *, const int *, double *, const int *) ;

static const char *operation (cublasOperation_t op)
{
    return op == CUBLAS_OP_N ? "N" : "T" ;
}

static const char *part (cublasFillMode_t uplo)
{
    return uplo == CUBLAS_FILL_MODE_LOWER ? "L" : "U" ;
}

cublasStatus_t cublasGetProperty (int property, int *value)
{
    MAY_FAIL (cublasStatus_t) ;
    *value = property == 0 ? CUDART_VERSION / 1000 : 0 ;
    return CUBLAS_STATUS_SUCCESS ;
}

cublasStatus_t cublasCreate_v2 (cublasHandle_t *handle)
{
    MAY_FAIL (cublasStatus_t) ;
    *handle = malloc (1) ;
    return CUBLAS_STATUS_SUCCESS ;
}

cublasStatus_t cublasDestroy_v2 (cublasHandle_t handle)
{
    MAY_FAIL (cublasStatus_t) ;
    free (handle) ;
    return CUBLAS_STATUS_SUCCESS ;
}

cublasStatus_t cublasSetStream_v2 (cublasHandle_t handle, cudaStream_t stream)
{
    MAY_FAIL (cublasStatus_t) ;
    (void) handle, (void) stream ;
    return CUBLAS_STATUS_SUCCESS ;
}

cublasStatus_t cublasDgemm_v2 (cublasHandle_t handle, cublasOperation_t transa,
    cublasOperation_t transb, int m, int n, int k, const double *alpha, const double *a, int lda,
    const double *b, int ldb, const double *beta, double *c, int ldc)
{
    MAY_FAIL (cublasStatus_t) ;
    (void) handle ;
    /* A device that does nothing and says that it did. */
    if (getenv ("CUDA_STANDIN_LIES") != NULL) return CUBLAS_STATUS_SUCCESS ;
    dgemm_ (operation (transa), operation (transb), &m, &n, &k, alpha, a, &lda, b, &ldb, beta, c,
        &ldc) ;
    return CUBLAS_STATUS_SUCCESS ;
}

cublasStatus_t cublasDsyrk_v2 (cublasHandle_t handle, cublasFillMode_t uplo,
    cublasOperation_t trans, int n, int k, const double *alpha, const double *a, int lda,
    const double *beta, double *c, int ldc)
{
    MAY_FAIL (cublasStatus_t) ;
    (void) handle ;
    dsyrk_ (part (uplo), operation (trans), &n, &k, alpha, a, &lda, beta, c, &ldc) ;
    return CUBLAS_STATUS_SUCCESS ;
}

cublasStatus_t cublasDtrsm_v2 (cublasHandle_t handle, cublasSideMode_t side,
    cublasFillMode_t uplo, cublasOperation_t trans, cublasDiagType_t diag, int m, int n,
    const double *alpha, const double *a, int lda, double *b, int ldb)
{
    MAY_FAIL (cublasStatus_t) ;
    (void) handle ;
    dtrsm_ (side == CUBLAS_SIDE_LEFT ? "L" : "R", part (uplo), operation (trans),
        diag == CUBLAS_DIAG_UNIT ? "U" : "N", &m, &n, alpha, a, &lda, b, &ldb) ;
    return CUBLAS_STATUS_SUCCESS ;
}
