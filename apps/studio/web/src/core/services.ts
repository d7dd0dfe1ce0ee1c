// What the panels of one studio share: stores and the like, one of each class, made when first asked for.

/** A class whose one object an owner has; `dispose`, if it is there, is called when the owner ends. */
type ServiceType<Owner, Service> = new (owner: Owner) => Service;

export class Services<Owner> {
  private readonly made = new Map<ServiceType<Owner, object>, { dispose?(): void }>();

  constructor(private readonly owner: Owner) {}

  get<Service extends object>(type: ServiceType<Owner, Service>): Service {
    let service = this.made.get(type) as Service | undefined;
    if (!service) this.made.set(type, (service = new type(this.owner)));
    return service;
  }

  /** The newest ends first: it may use what was there before it. */
  dispose(): void {
    const all = [...this.made.values()].reverse();
    this.made.clear();
    for (const service of all) service.dispose?.();
  }
}
