/* What the bindings are generated from. */
#include <cholmod.h>
#include <metis.h>
