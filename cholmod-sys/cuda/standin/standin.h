/* A stand-in for CUDA on the CPU, for tests alone: it walks CHOLMOD's GPU code
 * where there is no GPU. It does at once what CUDA does in its own time, so it
 * tells nothing about speed, and it names itself wherever it is asked.
 *
 * CUDA_STANDIN_FAIL=FUNCTION:K[:ERROR] makes the K-th call of a function, and
 * each one after it, fail with an error (default 999, "unknown").
 * CUDA_STANDIN_LIES makes products of matrices do nothing and report success.
 * CUDA_STANDIN_MEMORY is the memory of the device in bytes (default 1 GiB). */
#ifndef DEMPFV_STANDIN_H
#define DEMPFV_STANDIN_H

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The error with which this call fails; 0 where it does not. `calls` counts the
 * calls of one function. */
static inline int standin_failure (const char *function, atomic_long *calls)
{
    long call = ++*calls ;
    const char *wish = getenv ("CUDA_STANDIN_FAIL") ;
    size_t length = strlen (function) ;
    if (wish == NULL || strncmp (wish, function, length) != 0 || wish [length] != ':') return 0 ;
    long first = 1, error = 999 ;
    sscanf (wish + length, ":%ld:%ld", &first, &error) ;
    return call >= first ? (int) error : 0 ;
}

/* Ends the function where this call is to fail. */
#define MAY_FAIL(type) \
    do \
    { \
        static atomic_long calls ; \
        int error = standin_failure (__func__, &calls) ; \
        if (error != 0) return (type) error ; \
    } while (0)

#endif
