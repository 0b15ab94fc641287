/* What the app's glue uses of the firmware, for a check of its syntax and types: names and types as documented by
   Bitcraze (app layer, P2P, out-of-tree controllers, logging) and FreeRTOS; no behaviour. */
#ifndef FIRMWARE_H
#define FIRMWARE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct { float x, y, z; } vector_t;
typedef struct { float x, y, z, w; } quaternion_t;
typedef struct { vector_t position, velocity, acc; quaternion_t attitudeQuaternion; } state_t;
typedef struct { vector_t position, velocity, acceleration; } setpoint_t;
typedef struct { int16_t roll, pitch, yaw; float thrust; } control_t;
typedef struct { vector_t acc, gyro; } sensorData_t;
typedef uint32_t stabilizerStep_t;
typedef struct { uint8_t size, rssi, port, data[60]; } P2PPacket;
typedef void *QueueHandle_t;

#define RATE_500_HZ 500
#define RATE_DO_EXECUTE(rate, step) ((step) % (1000 / (rate)) == 0)
#define M2T(milliseconds) ((uint32_t)(milliseconds))
#define pdTRUE 1
#define STATIC_MEM_QUEUE_ALLOC(name, length, size) static uint8_t name##_memory[(length) * (size)]
#define STATIC_MEM_QUEUE_CREATE(name) ((QueueHandle_t)name##_memory)
#define PARAM_GROUP_START(name)
#define PARAM_GROUP_STOP(name)
#define PARAM_ADD(type, name, address) static const void *const param_##name = (address);
#define LOG_GROUP_START(name)
#define LOG_GROUP_STOP(name)
#define LOG_ADD(type, name, address) static const void *const log_##name = (address);

void appMain(void);
void controllerOutOfTreeInit(void);
bool controllerOutOfTreeTest(void);
void controllerOutOfTree(control_t *, const setpoint_t *, const sensorData_t *, const state_t *, stabilizerStep_t);
void controllerMellingerFirmwareInit(void);
bool controllerMellingerFirmwareTest(void);
void controllerMellingerFirmware(control_t *, const setpoint_t *, const sensorData_t *, const state_t *, stabilizerStep_t);
bool supervisorIsFlying(void);
uint64_t usecTimestamp(void);
uint64_t configblockGetRadioAddress(void);
bool radiolinkSendP2PPacketBroadcast(P2PPacket *);
void p2pRegisterCB(void (*)(P2PPacket *));
void vTaskDelay(uint32_t);
int xQueueSend(QueueHandle_t, const void *, uint32_t);
int xQueueOverwrite(QueueHandle_t, const void *);
int xQueueReceive(QueueHandle_t, void *, uint32_t);

#endif
