/* The app in the firmware: an out-of-tree controller that corrects Mellinger's acceleration setpoint.

   appMain broadcasts this vehicle's motion every Q2Q_PERIOD_S; packets of others wait in a queue, since they
   arrive in the radio's task. The controller empties it, takes a step at 500 Hz, and lets Mellinger fly the
   setpoint with the acceleration less eta^. Interface: out-of-tree controllers and P2P broadcasts as documented
   by Bitcraze. */
#include "FreeRTOS.h"
#include "app.h"
#include "configblock.h"
#include "controller.h"
#include "controller_mellinger.h"
#include "log.h"
#include "param.h"
#include "queue.h"
#include "radiolink.h"
#include "static_mem.h"
#include "supervisor.h"
#include "task.h"
#include "usec_time.h"

#include "q2q_app.h"

#define PORT 1       /* of P2P packets */
#define WAITING 10   /* packets: two periods of all neighbours */
#define AGE_US 2000u /* of a packet when it arrives: one transmission */

struct packet {
  uint32_t stamp_us;
  uint8_t bytes[Q2Q_PACKET_BYTES];
};

static struct q2q_app app;
static float eta;                                 /* subtracted from the setpoint [m/s^2] */
static float newton_per_pwm = Q2Q_NEWTON_PER_PWM; /* thrust of all motors over their common command */
static uint8_t enabled = 1;                       /* 0: predict and log, but leave the setpoint alone */
static bool ready;                                /* the queues exist */
static control_t last;

STATIC_MEM_QUEUE_ALLOC(heard, WAITING, sizeof(struct packet));
STATIC_MEM_QUEUE_ALLOC(present, 1, sizeof(struct q2q_motion));
static QueueHandle_t heard, present;

static void receive(P2PPacket *p2p) {
  struct packet packet = {.stamp_us = (uint32_t)usecTimestamp() - AGE_US};
  if (p2p->port != PORT || p2p->size != Q2Q_PACKET_BYTES) return;
  for (int k = 0; k < Q2Q_PACKET_BYTES; ++k) packet.bytes[k] = p2p->data[k];
  xQueueSend(heard, &packet, 0);
}

void appMain(void) {
  const uint8_t id = (uint8_t)(configblockGetRadioAddress() & 0xffu);
  heard = STATIC_MEM_QUEUE_CREATE(heard);
  present = STATIC_MEM_QUEUE_CREATE(present);
  p2pRegisterCB(receive);
  ready = true;
  while (1) {
    static P2PPacket packet;
    struct q2q_motion motion;
    vTaskDelay(M2T((uint32_t)(1000.0f * Q2Q_PERIOD_S)));
    if (xQueueReceive(present, &motion, 0) != pdTRUE) continue;
    packet.port = PORT;
    packet.size = Q2Q_PACKET_BYTES;
    if (!q2q_pack(id, &motion, packet.data)) continue;
    radiolinkSendP2PPacketBroadcast(&packet);
  }
}

static void listen(void) {
  struct packet packet;
  while (xQueueReceive(heard, &packet, 0) == pdTRUE) {
    struct q2q_motion motion;
    const uint8_t id = q2q_unpack(packet.bytes, &motion);
    q2q_hear(&app, id, packet.stamp_us, &motion);
  }
}

static void step(const state_t *state) {
  const quaternion_t q = state->attitudeQuaternion;
  const struct q2q_motion own = {
      .pos = {state->position.x, state->position.y, state->position.z},
      .vel = {state->velocity.x, state->velocity.y, state->velocity.z},
      .axis = {2.0f * (q.x * q.z + q.w * q.y), 2.0f * (q.y * q.z - q.w * q.x), 1.0f - 2.0f * (q.x * q.x + q.y * q.y)}};
  const struct q2q_input input = {
      .now_us = (uint32_t)usecTimestamp(),
      .own = own,
      .force_up = Q2Q_GRAVITY * (state->acc.z + 1.0f), /* the estimator's, of the accelerometer [g] */
      .thrust = newton_per_pwm * last.thrust / Q2Q_MASS,
      .flying = supervisorIsFlying()};
  listen();
  eta = q2q_step(&app, &input);
  xQueueOverwrite(present, &own);
}

void controllerOutOfTreeInit(void) {
  q2q_reset(&app);
  controllerMellingerFirmwareInit();
}

bool controllerOutOfTreeTest(void) { return controllerMellingerFirmwareTest(); }

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t stabilizerStep) {
  setpoint_t corrected = *setpoint;
  if (ready && RATE_DO_EXECUTE(RATE_500_HZ, stabilizerStep)) step(state);
  if (enabled) corrected.acceleration.z -= eta;
  controllerMellingerFirmware(control, &corrected, sensors, state, stabilizerStep);
  last = *control;
}

PARAM_GROUP_START(q2q)
PARAM_ADD(PARAM_UINT8, enabled, &enabled)
PARAM_ADD(PARAM_FLOAT, newtonPerPwm, &newton_per_pwm)
PARAM_GROUP_STOP(q2q)

LOG_GROUP_START(q2q)
LOG_ADD(LOG_FLOAT, eta, &eta)
LOG_ADD(LOG_FLOAT, residual, &app.correction.residual)
LOG_ADD(LOG_FLOAT, offset, &app.correction.offset)
LOG_ADD(LOG_UINT32, unheard, &app.unheard)
LOG_GROUP_STOP(q2q)
