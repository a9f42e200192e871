/* The drive as an actuator of MuJoCo: `law` maps motion, force and temperatures to powers and demands, without global state. */

#include <mujoco/mujoco.h>
#include <stdlib.h>
#include <string.h>

enum { ENERGY, WINDING, HOUSING, STATES }; /* of an actuator, in `act`: [J], rises above ambient [K] */

static const double tolerance = 1e-12; /* of a demand, relative to its limit */

static int actuator_of(const mjModel *m, int instance)
{
    int found = -1, count = 0;
    for (int id = 0; id < (int)m->nu; id++) {
        if (m->actuator_plugin[id] == instance) {
            found = id;
            count++;
        }
    }
    return count == 1 && m->actuator_actnum[found] == STATES ? found : -1;
}

/* Place of what a sensor measures, by what follows the last dot of its name; -1 if nothing does. */
static int measured(const mjModel *m, int sensor)
{
    const char *dot = strrchr(m->names + m->name_sensoradr[sensor], '.');
    for (int place = 0; dot && place < SENSORS; place++) {
        if (!strcmp(dot + 1, sensors[place])) {
            return place;
        }
    }
    return -1;
}

static double ambient_of(const mjModel *m, int instance)
{
    const char *text = mj_getPluginConfig(m, instance, "ambient");
    char *end = NULL;
    const double value = text && *text ? strtod(text, &end) : AMBIENT;
    return end && *end ? NAN : value;
}

static double evaluated(double *u, double force, double *y)
{
    u[FORCE] = force;
    law(u, y);
    return force;
}

/* Largest demand over its allowance among what limits the force, less 1; infinite where there is no motion. */
static double excess(double *u, double force, double *y)
{
    double worst = 0.0;
    (void)evaluated(u, force, y);
    for (int i = 0; i < LIMITS; i++) {
        const double one = y[limits[i]];
        worst = isfinite(one) ? fmax(worst, one) : INFINITY;
    }
    return worst - 1.0;
}

/* Voltage over that of the supply, in its direction without force, less 1. */
static double overvoltage(double *u, double force, double *y)
{
    (void)evaluated(u, force, y);
    return isfinite(y[VOLTAGE_OUT]) ? y[VOLTAGE_OUT] / u[SUPPLY] - 1.0 : INFINITY;
}

/* Where a measure passes 0 between a force at which it is `low` <= 0 and one at which it is `high` > 0. */
static double boundary(double (*measure)(double *, double, double *), double *u, double inner, double low, double outer,
                       double high, double *y)
{
    for (int i = 0, side = 0; i < 200 && low < -tolerance && fabs(outer - inner) > tolerance * fabs(outer); i++) {
        const double share = isfinite(high) ? low / (low - high) : 0.5;
        const double force = inner + (share > 0.0 && share < 1.0 && i < 100 ? share : 0.5) * (outer - inner);
        const double found = measure(u, force, y);
        if (found <= tolerance) {
            inner = force;
            low = found;
            high *= side < 0 ? 0.5 : 1.0;
            side = -1;
        } else {
            outer = force;
            high = found;
            low *= side > 0 ? 0.5 : 1.0;
            side = 1;
        }
    }
    return evaluated(u, inner, y);
}

/* Above its no-load speed the motor brakes: its voltage drives a current through the amplifier. None where there is no motion. */
static double braking(double *u, double *y)
{
    double last = 0.0, before, now;
    (void)evaluated(u, 0.0, y);
    u[SUPPLY] = y[VOLTAGE_OUT] / y[VOLTAGE_DEMAND];
    before = overvoltage(u, 0.0, y);
    for (double force = u[SPEED] > 0.0 ? -1e-3 : 1e-3; before > 0.0 && fabs(force) < 1e12; force *= 2.0) {
        now = overvoltage(u, force, y);
        if (now <= 0.0) {
            return boundary(overvoltage, u, force, now, last, before, y);
        }
        last = force;
        before = now;
    }
    return evaluated(u, 0.0, y);
}

/* Force within the limits next to the wanted one, between it and none; `y` is what it demands. */
static double within(double *u, double wanted, double *y)
{
    double low, high = excess(u, wanted, y);
    if (high <= tolerance) {
        return wanted;
    }
    low = excess(u, 0.0, y);
    return low <= tolerance ? boundary(excess, u, 0.0, low, wanted, high, y) : braking(u, y);
}

static void given(const mjModel *m, const mjData *d, int instance, int id, double *u)
{
    const double *act = d->act + m->actuator_actadr[id];
    const double ambient = d->plugin_state[m->plugin_stateadr[instance]];
    u[POSITION] = d->actuator_length[id];
    u[SPEED] = d->actuator_velocity[id];
    u[WINDING_IN] = ambient + act[WINDING];
    u[HOUSING_IN] = ambient + act[HOUSING];
    u[AMBIENT_IN] = ambient;
}

/* Force of an actuator, and what it demands. */
static double driven(const mjModel *m, const mjData *d, int instance, int id, double *y)
{
    double u[SUPPLY + 1], wanted = isfinite(d->ctrl[id]) ? d->ctrl[id] : 0.0;
    if (m->actuator_ctrllimited[id] && !(m->opt.disableflags & mjDSBL_CLAMPCTRL)) {
        wanted = fmin(fmax(wanted, m->actuator_ctrlrange[2 * id]), m->actuator_ctrlrange[2 * id + 1]);
    }
    if (m->actuator_forcelimited[id]) {
        wanted = fmin(fmax(wanted, m->actuator_forcerange[2 * id]), m->actuator_forcerange[2 * id + 1]);
    }
    given(m, d, instance, id, u);
    return within(u, wanted, y);
}

static void derivatives(const mjModel *m, mjData *d, int instance)
{
    const int id = actuator_of(m, instance);
    double y[OUTPUTS];
    (void)driven(m, d, instance, id, y);
    for (int i = 0; i < STATES; i++) {
        const double rate = y[rates[i]];
        d->act_dot[m->actuator_actadr[id] + i] = isfinite(rate) ? rate : 0.0;
    }
}

static void compute(const mjModel *m, mjData *d, int instance, int capability)
{
    const int id = actuator_of(m, instance);
    double u[SUPPLY + 1], y[OUTPUTS];
    if (capability & mjPLUGIN_ACTUATOR) {
        d->actuator_force[id] = driven(m, d, instance, id, y);
    }
    if (capability & mjPLUGIN_SENSOR) {
        given(m, d, instance, id, u);
        (void)evaluated(u, d->actuator_force[id], y);
        for (int sensor = 0; sensor < (int)m->nsensor; sensor++) {
            if (m->sensor_type[sensor] == mjSENS_PLUGIN && m->sensor_plugin[sensor] == instance) {
                const int place = measured(m, sensor);
                const double *act = d->act + m->actuator_actadr[id];
                d->sensordata[m->sensor_adr[sensor]] = place == ENERGY ? act[ENERGY]
                                                       : place == WINDING ? u[WINDING_IN]
                                                       : place == HOUSING ? u[HOUSING_IN]
                                                                          : y[place - STATES];
            }
        }
    }
}

static int one_state(const mjModel *m, int instance)
{
    (void)m, (void)instance;
    return 1;
}

static int one_number(const mjModel *m, int instance, int sensor)
{
    (void)m, (void)instance, (void)sensor;
    return 1;
}

static int begin(const mjModel *m, mjData *d, int instance)
{
    (void)d;
    const char *wanted = mj_getPluginConfig(m, instance, "version");
    if (wanted && *wanted && strcmp(wanted, version)) {
        mju_warning("%s: this process has loaded another drive of that name before; start a new one", plugin_name);
        return -1;
    }
    const int id = actuator_of(m, instance);
    if (id < 0) {
        mju_warning("%s: an instance needs exactly one actuator, with actdim=\"%d\"", plugin_name, STATES);
        return -1;
    }
    if (m->actuator_trntype[id] == mjTRN_JOINT && m->jnt_type[m->actuator_trnid[2 * id]] != (ROTARY ? mjJNT_HINGE : mjJNT_SLIDE)) {
        mju_warning("%s: the joint of the actuator must be of type %s", plugin_name, ROTARY ? "hinge" : "slide");
        return -1;
    }
    if (!(ambient_of(m, instance) > 0.0 && isfinite(ambient_of(m, instance)))) {
        mju_warning("%s: ambient must be a temperature in K, such as 298.15", plugin_name);
        return -1;
    }
    for (int sensor = 0; sensor < (int)m->nsensor; sensor++) {
        if (m->sensor_type[sensor] == mjSENS_PLUGIN && m->sensor_plugin[sensor] == instance && measured(m, sensor) < 0) {
            mju_warning("%s: the name of sensor '%s' must end in '.' and one of: %s", plugin_name,
                        m->names + m->name_sensoradr[sensor], known);
            return -1;
        }
    }
    return 0;
}

static void reset(const mjModel *m, mjtNum *state, void *data, int instance)
{
    (void)data;
    state[0] = ambient_of(m, instance);
}

/* The first of a name stays, and refuses models of another version: an error in here would leave the loader of libraries locked. */
__attribute__((constructor)) static void registered(void)
{
    static const char *const attributes[] = {"ambient", "version"};
    mjpPlugin plugin;
    int place;
    if (mjp_getPlugin(plugin_name, &place)) {
        return;
    }
    mjp_defaultPlugin(&plugin);
    plugin.name = plugin_name;
    plugin.nattribute = 2;
    plugin.attributes = attributes;
    plugin.capabilityflags = mjPLUGIN_ACTUATOR | mjPLUGIN_SENSOR;
    plugin.needstage = mjSTAGE_ACC;
    plugin.nstate = one_state;
    plugin.nsensordata = one_number;
    plugin.init = begin;
    plugin.reset = reset;
    plugin.compute = compute;
    plugin.actuator_act_dot = derivatives;
    mjp_registerPlugin(&plugin);
}
