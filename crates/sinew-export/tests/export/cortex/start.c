/* Vector table and start of a Cortex-M; its FPU is switched on. */
#include <stdint.h>
extern const uint32_t stack_top[];
void _start(void);
void reset(void);
void stuck(void);
typedef union {
    const uint32_t *top;
    void (*handler)(void);
} entry;
__attribute__((section(".vectors"), used)) const entry vectors[16] = {
    {.top = stack_top}, {.handler = reset}, {.handler = stuck}, {.handler = stuck}, {.handler = stuck},
    {.handler = stuck}, {.handler = stuck}
};
void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm volatile("dsb\n isb");
    _start();
}
void stuck(void)
{
    for (;;) {
    }
}
