/* What CHOLMOD's GPU module calls of cuBLAS, through the gate (gate.h): the
 * program needs neither cuBLAS nor its headers to be built or to start.
 * Types and constants are those of cuBLAS's stable C interface, version 2. */
#ifndef DEMPFV_CUBLAS_V2_H
#define DEMPFV_CUBLAS_V2_H

#include <cuda_runtime_api.h>

typedef struct cublasContext *cublasHandle_t ;
typedef enum { CUBLAS_STATUS_SUCCESS = 0, CUBLAS_STATUS_NOT_SUPPORTED = 15 } cublasStatus_t ;
typedef enum { CUBLAS_FILL_MODE_LOWER = 0, CUBLAS_FILL_MODE_UPPER = 1 } cublasFillMode_t ;
typedef enum { CUBLAS_DIAG_NON_UNIT = 0, CUBLAS_DIAG_UNIT = 1 } cublasDiagType_t ;
typedef enum { CUBLAS_SIDE_LEFT = 0, CUBLAS_SIDE_RIGHT = 1 } cublasSideMode_t ;
typedef enum { CUBLAS_OP_N = 0, CUBLAS_OP_T = 1, CUBLAS_OP_C = 2 } cublasOperation_t ;
typedef double2 cuDoubleComplex ;

cublasStatus_t gate_cublasCreate (cublasHandle_t *handle) ;
cublasStatus_t gate_cublasDestroy (cublasHandle_t handle) ;
cublasStatus_t gate_cublasSetStream (cublasHandle_t handle, cudaStream_t stream) ;
cublasStatus_t gate_cublasDgemm (cublasHandle_t handle, cublasOperation_t transa,
    cublasOperation_t transb, int m, int n, int k, const double *alpha, const double *a, int lda,
    const double *b, int ldb, const double *beta, double *c, int ldc) ;
cublasStatus_t gate_cublasDsyrk (cublasHandle_t handle, cublasFillMode_t uplo,
    cublasOperation_t trans, int n, int k, const double *alpha, const double *a, int lda,
    const double *beta, double *c, int ldc) ;
cublasStatus_t gate_cublasDtrsm (cublasHandle_t handle, cublasSideMode_t side,
    cublasFillMode_t uplo, cublasOperation_t trans, cublasDiagType_t diag, int m, int n,
    const double *alpha, const double *a, int lda, double *b, int ldb) ;

/* Complex matrices are never factored here; these refuse. */
cublasStatus_t gate_cublasZgemm (cublasHandle_t handle, cublasOperation_t transa,
    cublasOperation_t transb, int m, int n, int k, const cuDoubleComplex *alpha,
    const cuDoubleComplex *a, int lda, const cuDoubleComplex *b, int ldb,
    const cuDoubleComplex *beta, cuDoubleComplex *c, int ldc) ;
cublasStatus_t gate_cublasZherk (cublasHandle_t handle, cublasFillMode_t uplo,
    cublasOperation_t trans, int n, int k, const double *alpha, const cuDoubleComplex *a, int lda,
    const double *beta, cuDoubleComplex *c, int ldc) ;
cublasStatus_t gate_cublasZtrsm (cublasHandle_t handle, cublasSideMode_t side,
    cublasFillMode_t uplo, cublasOperation_t trans, cublasDiagType_t diag, int m, int n,
    const cuDoubleComplex *alpha, const cuDoubleComplex *a, int lda, cuDoubleComplex *b, int ldb) ;

#ifndef GATE_IMPLEMENTATION
#define cublasCreate gate_cublasCreate
#define cublasDestroy gate_cublasDestroy
#define cublasSetStream gate_cublasSetStream
#define cublasDgemm gate_cublasDgemm
#define cublasDsyrk gate_cublasDsyrk
#define cublasDtrsm gate_cublasDtrsm
#define cublasZgemm gate_cublasZgemm
#define cublasZherk gate_cublasZherk
#define cublasZtrsm gate_cublasZtrsm
#endif

#endif
