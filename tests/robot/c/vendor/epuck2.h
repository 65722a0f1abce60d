/* A stand-in for GCtronic's e-puck2_main-processor: the declarations that examples/recipes/epuck2.c uses. */

#include <stdbool.h>
#include <stdint.h>

#define MUTEX_DECL(name) int name
#define CONDVAR_DECL(name) int name
#define RNG_SR_DRDY 1u
#define RNG_CR_RNGEN 4u
#define RCC_AHB2ENR_RNGEN 64u
#define RCC (&rcc)
#define RNG rng_of_the_board()

typedef struct {
    int *lock, *condition;
} messagebus_t;
typedef int parameter_namespace_t;
typedef struct {
    uint32_t AHB2ENR;
} rcc_t;
typedef struct {
    uint32_t CR, SR, DR;
} rng_t;
typedef struct {
    long int value;
    float distance, direction;
    int receivingSensor, error;
} IrcomMessage;

extern rcc_t rcc;
rng_t *rng_of_the_board(void);
void halInit(void);
void chSysInit(void);
void chSysHalt(const char *reason);
void chThdSleepMilliseconds(uint32_t milliseconds);
void mpu_init(void);
void messagebus_init(messagebus_t *bus, void *lock, void *condition);
void motors_init(void);
void left_motor_set_speed(int speed);
void right_motor_set_speed(int speed);
void set_body_led(unsigned int value);
void set_front_led(unsigned int value);
int get_selector(void);
void ircomStart(void);
void ircomEnableContinuousListening(void);
void ircomListen(void);
void ircomSend(long int value);
int ircomSendDone(void);
void ircomPopMessage(IrcomMessage *message);
int ircom_get_calibrated_prox(unsigned int sensor);
