/* Counts calls of malloc, calloc and realloc; to be preloaded.   gcc -shared -fPIC malloc_count.c -o malloc_count.so */

#include <stddef.h>

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);

static long count;

long allocations(void) { return count; }
void *malloc(size_t size) { return __atomic_add_fetch(&count, 1, __ATOMIC_RELAXED), __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return __atomic_add_fetch(&count, 1, __ATOMIC_RELAXED), __libc_calloc(n, size); }
void *realloc(void *p, size_t size) { return __atomic_add_fetch(&count, 1, __ATOMIC_RELAXED), __libc_realloc(p, size); }
