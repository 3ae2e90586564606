/* Wine 8 (Debian 12) has no bcryptprimitives.dll, which every Rust program for Windows imports for one function: random
 * bytes, for the seeds of its hash maps. Wine 9 and Windows have it. Only for the test under Wine; never shipped. */
#include <windows.h>

/* RtlGenRandom of advapi32, under the name by which it is exported. */
BOOLEAN NTAPI SystemFunction036(PVOID buffer, ULONG length);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length)
{
    while (length > 0) {
        ULONG part = length > 4096 ? 4096 : (ULONG)length;
        if (!SystemFunction036(data, part))
            return FALSE;
        data += part;
        length -= part;
    }
    return TRUE;
}
