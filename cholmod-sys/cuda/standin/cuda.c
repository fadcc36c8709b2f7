/* The driver: CHOLMOD's kernels by their names, thread by thread. */

#include <cuda.h>
#include <stdint.h>
#include "standin.h"

static const char *const names [ ] =
    { "kernelCreateMap", "kernelCreateRelativeMap", "kernelAddUpdate", "kernelSumA" } ;

CUresult cuModuleLoadData (CUmodule *module, const void *image)
{
    MAY_FAIL (CUresult) ;
    (void) image ;
    *module = (CUmodule) names ;
    return CUDA_SUCCESS ;
}

CUresult cuModuleGetFunction (CUfunction *f, CUmodule module, const char *name)
{
    MAY_FAIL (CUresult) ;
    (void) module ;
    for (size_t k = 0 ; k < sizeof (names) / sizeof (names [0]) ; k++)
    {
        if (strcmp (name, names [k]) == 0)
        {
            *f = (CUfunction) &names [k] ;
            return CUDA_SUCCESS ;
        }
    }
    return CUDA_ERROR_NOT_FOUND ;
}

#define ARGUMENT(type, k) (*(type *) parameters [k])

CUresult cuLaunchKernel (CUfunction f, unsigned int gx, unsigned int gy, unsigned int gz,
    unsigned int bx, unsigned int by, unsigned int bz, unsigned int shared, CUstream stream,
    void **parameters, void **extra)
{
    MAY_FAIL (CUresult) ;
    (void) gz, (void) bz, (void) shared, (void) stream, (void) extra ;
    long kernel = (const char *const *) f - names ;
    for (int64_t y = 0 ; y < (int64_t) gy * by ; y++)
    {
        for (int64_t x = 0 ; x < (int64_t) gx * bx ; x++)
        {
            if (kernel == 0)
            {
                int64_t *map = ARGUMENT (int64_t *, 0), *rows = ARGUMENT (int64_t *, 1) ;
                if (x < ARGUMENT (int64_t, 3)) map [rows [ARGUMENT (int64_t, 2) + x]] = x ;
            }
            else if (kernel == 1)
            {
                int64_t *map = ARGUMENT (int64_t *, 0), *rows = ARGUMENT (int64_t *, 1) ;
                int64_t *relative = ARGUMENT (int64_t *, 2) ;
                if (x < ARGUMENT (int64_t, 4))
                {
                    relative [x] = map [rows [ARGUMENT (int64_t, 3) + x]] ;
                }
            }
            else if (kernel == 2)
            {
                double *a = ARGUMENT (double *, 0), *c = ARGUMENT (double *, 1) ;
                int64_t *relative = ARGUMENT (int64_t *, 2) ;
                int64_t rows = ARGUMENT (int64_t, 4), height = ARGUMENT (int64_t, 5) ;
                if (x < rows && y < ARGUMENT (int64_t, 3))
                {
                    a [relative [x] + relative [y] * height] += c [x + rows * y] ;
                }
            }
            else
            {
                double *a = ARGUMENT (double *, 0), *b = ARGUMENT (double *, 1) ;
                int64_t rows = ARGUMENT (int, 3) ;
                if (x < rows && y < ARGUMENT (int, 4))
                {
                    a [y * rows + x] += ARGUMENT (double, 2) * b [y * rows + x] ;
                }
            }
        }
    }
    return CUDA_SUCCESS ;
}
